#include "experiment/byte_parts.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "checksum.hpp"

namespace rivid::detail {

namespace {

constexpr std::uint32_t order_of_bytes = 0x01020304;  // mark of the format: its bytes tell their order

template <typename Number>
void put_number(std::string& out, Number value) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    out += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
  }
}

}  // namespace

PartWriter::PartWriter(std::string_view magic, std::uint32_t version, const Json& description) : out_(magic) {
  put_number(out_, version);
  put_number(out_, order_of_bytes);
  put_part(description.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string PartWriter::content() && {
  put_number(out_, checksum(out_));
  return std::move(out_);
}

void PartWriter::put_part(std::string_view part) {
  put_number(out_, static_cast<std::uint64_t>(part.size()));
  out_ += part;
}

PartReader::PartReader(std::string_view content, std::string_view magic, std::uint32_t wanted,
                       std::string_view holds, std::string_view source)
    : content_(content), source_(source) {
  if (content.empty() || !content.starts_with(magic.substr(0, content.size()))) {
    throw fault(std::string(holds));
  }
  take(magic.size());
  const auto version = number<std::uint32_t>();
  if (number<std::uint32_t>() != order_of_bytes) {
    throw fault("has its bytes in another order; the format is little-endian");
  }
  if (version != wanted) {
    throw fault("has version " + std::to_string(version) + " of the format; this rivid reads version " +
                std::to_string(wanted));
  }
  const std::string_view rest = content_;
  content_ = content.substr(content.size() - sizeof(std::uint64_t));
  if (number<std::uint64_t>() != checksum(content.substr(0, content.size() - sizeof(std::uint64_t)))) {
    throw fault("is truncated or damaged: its checksum does not fit its content");
  }
  content_ = rest;
  try {
    description_ = Json::parse(part());
  } catch (const Json::exception& e) {
    throw fault(std::string("is damaged: ") + e.what());
  }
}

InputError PartReader::fault(const std::string& what) const {
  return InputError(std::string(source_) + ": " + what);
}

Index PartReader::count(const char* key, Index most) const {
  const auto out = description_.at(key).get<Index>();
  if (out < 0 || out > most) {
    throw fault(std::string("is damaged: ") + key + " is " + std::to_string(out));
  }
  return out;
}

std::vector<std::vector<Index>> PartReader::columns() const {
  auto out = description_.at("columns").get<std::vector<std::vector<Index>>>();
  for (const std::vector<Index>& own : out) {
    const bool ascending = std::ranges::adjacent_find(own, std::greater_equal<>()) == own.end();
    if (!ascending || (!own.empty() && own.front() < 0)) {
      throw fault("is damaged: columns of a joint are not ascending");
    }
  }
  return out;
}

void PartReader::expect_end() const {
  if (content_.size() != sizeof(std::uint64_t)) {
    throw fault("is damaged: its parts do not fit together");
  }
}

template <typename Number>
Number PartReader::number() {
  const std::string_view bytes = take(sizeof(Number));
  Number value = 0;
  for (std::size_t i = 0; i < sizeof value; ++i) {
    value |= static_cast<Number>(static_cast<Number>(static_cast<unsigned char>(bytes[i])) << (8 * i));
  }
  return value;
}

std::string_view PartReader::part() { return take(number<std::uint64_t>()); }

std::string_view PartReader::take(std::uint64_t count) {
  if (count > content_.size()) {
    throw fault("is truncated");
  }
  const std::string_view out = content_.substr(0, count);
  content_.remove_prefix(count);
  return out;
}

}  // namespace rivid::detail
