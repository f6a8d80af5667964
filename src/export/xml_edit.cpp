#include "export/xml_edit.hpp"

#include <algorithm>
#include <utility>

#include "report/markup.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr std::string_view blanks = " \t\r\n";

// Line end and blanks that stand before the line that holds `at`; empty where other text does.
std::string line_start(std::string_view text, std::size_t at) {
  const std::size_t newline = text.rfind('\n', at);
  const std::size_t begin = newline == std::string_view::npos ? 0 : newline + 1;
  const std::size_t end = std::min(text.find_first_not_of(" \t", begin), at);
  const std::string_view ending = newline == std::string_view::npos          ? ""
                                  : newline > 0 && text[newline - 1] == '\r' ? "\r\n"
                                                                             : "\n";
  return std::string(ending) + std::string(text.substr(begin, end - begin));
}

}  // namespace

const StartTag::Attribute* StartTag::attribute(std::string_view wanted) const {
  const auto at = std::ranges::find(attributes, wanted, &Attribute::name);
  return at == attributes.end() ? nullptr : &*at;
}

StartTag start_tag(std::string_view text, std::size_t name_begin) {
  StartTag out;
  out.name_end = text.find_first_of(" \t\r\n/>", name_begin);
  out.name = text.substr(name_begin, out.name_end - name_begin);
  std::size_t at = text.find_first_not_of(blanks, out.name_end);
  while (text[at] != '>' && text[at] != '/') {
    const std::size_t name_end = text.find_first_of(" \t\r\n=", at);
    const std::size_t quote = text.find_first_of("\"'", name_end);
    const std::size_t closing = text.find(text[quote], quote + 1);
    out.attributes.push_back(
        {text.substr(at, name_end - at), text.substr(quote + 1, closing - quote - 1), quote + 1});
    at = text.find_first_not_of(blanks, closing + 1);
  }
  out.closed = text[at] == '/';
  out.end = text.find('>', at) + 1;
  return out;
}

std::string xml_attribute(std::string_view key, std::string_view value) {
  return " " + std::string(key) + "=\"" + escaped(value) + '"';
}

std::string xml_attribute(std::string_view key, double value) { return xml_attribute(key, exact(value)); }

void Splice::replace(std::size_t begin, std::size_t length, std::string content) {
  edits_.push_back({begin, length, std::move(content)});
}

void Splice::set(const StartTag& tag, std::string_view attribute, const std::string& value) {
  if (const StartTag::Attribute* const present = tag.attribute(attribute)) {
    replace(present->begin, present->value.size(), value);
  } else {
    replace(tag.name_end, 0, " " + std::string(attribute) + "=\"" + value + "\"");
  }
}

void Splice::insert_child(const StartTag& parent, const std::vector<std::string>& lines) {
  const std::string outer = line_start(text_, parent.end - 1);
  std::string before = outer.empty() ? outer : outer + "  ";
  if (!parent.closed) {
    // As the first of its children stands, in a line of its own or not.
    const std::size_t next = text_.find_first_not_of(blanks, parent.end);
    const bool same_line = text_.substr(parent.end, next - parent.end).find('\n') == std::string_view::npos;
    const bool is_end = text_.substr(next, 2) == "</";
    before = same_line ? std::string() : is_end ? before : line_start(text_, next);
  }
  std::string content;
  for (const std::string& line : lines) {
    content += before.empty() ? line.substr(line.find_first_not_of(' ')) : before + line;
  }
  if (parent.closed) {
    const std::size_t slash = text_.rfind('/', parent.end);
    replace(slash, parent.end - slash, ">" + content + outer + "</" + std::string(parent.name) + ">");
  } else {
    replace(parent.end, 0, content);
  }
}

std::string Splice::result() const {
  std::vector<Edit> edits = edits_;
  std::ranges::stable_sort(edits, {}, &Edit::begin);
  std::string out;
  std::size_t done = 0;
  for (const Edit& edit : edits) {
    out.append(text_.substr(done, edit.begin - done)).append(edit.content);
    done = edit.begin + edit.length;
  }
  return out.append(text_.substr(done));
}

}  // namespace rivid::detail
