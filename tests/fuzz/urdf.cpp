// URDF and its write-back: a rewritten file can be read, has the parameters that were written, and differs in
// numbers of <inertial> and <dynamics> alone.

#include "rivid/export/urdf.hpp"

#include <pugixml.hpp>

#include "harness.hpp"
#include "rivid/model/urdf.hpp"

namespace {

using namespace rivid;

bool is_one_of(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::ranges::find(names, name) != names.end();
}

// Whether numbers of this element may change, and what may be added to it.
bool holds_numbers(const pugi::xml_node& node) {
  const std::string_view parent = node.parent().name();
  return is_one_of(node.name(), {"inertial", "dynamics"}) || parent == "inertial";
}

bool may_be_added(const pugi::xml_node& node) {
  return node.type() == pugi::node_pcdata || holds_numbers(node);
}

void expect_same_attributes(const pugi::xml_node& before, const pugi::xml_node& after) {
  auto other = after.attributes().begin();
  const auto end = after.attributes().end();
  for (const pugi::xml_attribute& attribute : before.attributes()) {
    while (other != end && std::string_view(other->name()) != attribute.name() && holds_numbers(before)) {
      ++other;  // it was missing
    }
    fuzz::require(other != end && std::string_view(other->name()) == attribute.name(), "attributes stay");
    fuzz::require(holds_numbers(before) || std::string_view(other->value()) == attribute.value(),
                  "values of other elements stay");
    ++other;
  }
  fuzz::require(holds_numbers(before) || other == end, "no attribute is added elsewhere");
}

void expect_other_numbers_alone(const pugi::xml_node& before, const pugi::xml_node& after) {
  expect_same_attributes(before, after);
  auto other = after.begin();
  for (const pugi::xml_node& child : before) {
    while (other != after.end() && std::string_view(other->name()) != child.name() && may_be_added(*other)) {
      ++other;
    }
    fuzz::require(other != after.end() && other->type() == child.type() &&
                      std::string_view(other->value()) == child.value(),
                  "elements and texts stay");
    expect_other_numbers_alone(child, *other);
    ++other;
  }
  for (; other != after.end(); ++other) {
    fuzz::require(may_be_added(*other), "nothing else is added");
  }
}

void expect_rewritten(std::string_view xml, const Robot& robot, const Vector& chi_st) {
  const auto rewritten = fuzz::accepted([&] { return rewritten_urdf(xml, "robot.urdf", robot, chi_st); });
  if (!rewritten || !rewritten->faults.empty()) {
    return;
  }
  const Robot again = fuzz::read_back("a rewritten URDF is readable",
                                      [&] { return parse_urdf(rewritten->text, "again.urdf"); });
  const Vector read = again.chi_st();
  fuzz::require(read.size() == chi_st.size(), "the same parameters");
  pugi::xml_document before;
  pugi::xml_document after;
  constexpr unsigned all = pugi::parse_full;
  before.load_buffer(xml.data(), xml.size(), all);
  after.load_buffer(rewritten->text.data(), rewritten->text.size(), all);
  expect_other_numbers_alone(before, after);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view xml(reinterpret_cast<const char*>(data), size);
  const auto robot = fuzz::accepted([&] { return parse_urdf(xml, "robot.urdf"); });
  if (robot) {
    fuzz::require(!robot->complaint(), "a robot that was read can be used");
    const Vector chi_st = robot->chi_st();
    expect_rewritten(xml, *robot, chi_st);
    expect_rewritten(xml, *robot, 1.25 * chi_st);
  }
  return 0;
}
