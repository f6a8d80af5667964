#include "identify/figures/numpy_archive.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

void append_number(std::string& to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) {
    to += static_cast<char>((value >> (8 * i)) & 0xFF);
  }
}

// CRC-32 of ISO 3309, as zip archives have it.
std::uint32_t checksum(std::string_view bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> out{};
    for (std::uint32_t i = 0; i < out.size(); ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) {
        value = (value & 1U) != 0 ? 0xEDB88320U ^ (value >> 1) : value >> 1;
      }
      out[i] = value;
    }
    return out;
  }();
  std::uint32_t out = 0xFFFFFFFFU;
  for (const char c : bytes) {
    out = table[(out ^ static_cast<unsigned char>(c)) & 0xFFU] ^ (out >> 8);
  }
  return ~out;
}

// An array in the format of NumPy, version 1.0.
std::string npy(const std::string& type, const std::string& shape, std::string_view data) {
  std::string header = "{'descr': '" + type + "', 'fortran_order': True, 'shape': (" + shape + "), }";
  constexpr std::size_t alignment = 64;  // [bytes] of the data, by the format
  // [bytes] magic string (6), version (2) and length of the header (2), by the format
  constexpr std::size_t before = 10;
  header.resize((before + header.size() + alignment) / alignment * alignment - before - 1, ' ');
  header += '\n';
  std::string out = "\x93NUMPY";
  out += '\x01';
  out += '\0';
  append_number(out, header.size(), 2);
  return out.append(header).append(data);
}

std::string npy(const Eigen::Ref<const Matrix>& values, const std::string& shape) {
  static_assert(std::endian::native == std::endian::little, "NumPy's '<f8' is little-endian");
  std::string data(static_cast<std::size_t>(values.size()) * sizeof(double), '\0');
  std::memcpy(data.data(), values.data(), data.size());
  return npy("<f8", shape, data);
}

// UTF-8 as strings of four bytes a character, all of one length.
std::string npy(const std::vector<std::string>& names) {
  std::size_t longest = 1;
  for (const std::string& name : names) {
    longest = std::max(longest, display_width(name));
  }
  std::string data;
  for (const std::string& name : names) {
    std::string text;
    std::uint32_t character = 0;
    for (std::size_t i = 0; i < name.size(); ++i) {
      const auto byte = static_cast<unsigned char>(name[i]);
      const bool continues = (byte & 0xC0U) == 0x80U;
      const unsigned lead = byte < 0x80U ? 0x7FU : byte < 0xE0U ? 0x1FU : byte < 0xF0U ? 0x0FU : 0x07U;
      character = continues ? (character << 6) | (byte & 0x3FU) : byte & lead;
      if (i + 1 == name.size() || (static_cast<unsigned char>(name[i + 1]) & 0xC0U) != 0x80U) {
        append_number(text, character, 4);
      }
    }
    text.resize(4 * longest, '\0');
    data += text;
  }
  return npy("<U" + std::to_string(longest), std::to_string(names.size()) + ",", data);
}

}  // namespace

void NumpyArchive::add(const std::string& name, const Vector& values) {
  store(name, npy(values, std::to_string(values.size()) + ","));
}

void NumpyArchive::add(const std::string& name, const Matrix& values) {
  store(name, npy(values, std::to_string(values.rows()) + ", " + std::to_string(values.cols())));
}

void NumpyArchive::add(const std::string& name, const std::vector<std::string>& texts) {
  store(name, npy(texts));
}

void NumpyArchive::store(const std::string& name, const std::string& content) {
  if (out_.size() + content.size() > std::numeric_limits<std::uint32_t>::max() - (1U << 16)) {
    throw InputError("to_npz: the rows make up 4 GiB and more; write them as CSV");
  }
  const std::string member = name + ".npy";
  std::string common;
  append_number(common, 20, 2);          // version that reads it
  append_number(common, 0, 4);           // flags, stored
  append_number(common, 0x00210000, 4);  // 1 January 1980, so that equal rows are equal files
  append_number(common, checksum(content), 4);
  append_number(common, content.size(), 4);
  append_number(common, content.size(), 4);
  append_number(common, member.size(), 2);
  append_number(common, 0, 2);
  append_number(directory_, 0x02014b50, 4);
  append_number(directory_, 20, 2);
  directory_ += common;
  directory_.append(10, '\0');  // no comment, one disk, no attributes
  append_number(directory_, out_.size(), 4);
  directory_ += member;
  append_number(out_, 0x04034b50, 4);
  out_ += common + member + content;
  ++members_;
}

std::string NumpyArchive::finished() {
  const std::size_t start = out_.size();
  out_ += directory_;
  append_number(out_, 0x06054b50, 4);
  append_number(out_, 0, 4);
  append_number(out_, members_, 2);
  append_number(out_, members_, 2);
  append_number(out_, directory_.size(), 4);
  append_number(out_, start, 4);
  append_number(out_, 0, 2);
  return std::move(out_);
}

}  // namespace rivid::detail
