#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>

#include "rivid/error.hpp"
#include "rivid/solve/streaming_qr.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

constexpr std::string_view magic = "rivid-QR";
constexpr std::uint32_t version = 1;
constexpr std::uint32_t byte_order = 0x01020304;
constexpr std::size_t header_size = 8 + 2 * 4 + 3 * 8;
// Sizes beyond this are damage, and products of smaller ones do not overflow.
constexpr std::uint64_t most_columns = 1'000'000;

// Shifts instead of copied memory: the same bytes on every machine.
template <typename Number>
void put(std::string& out, Number value) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    out += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
  }
}

void put(std::string& out, double value) { put(out, std::bit_cast<std::uint64_t>(value)); }

class Reader {
 public:
  explicit Reader(std::string_view content) : content_(content) {}

  template <typename Number>
  Number next() {
    Number value = 0;
    for (std::size_t i = 0; i < sizeof value; ++i) {
      value |=
          static_cast<Number>(static_cast<Number>(static_cast<unsigned char>(content_[at_++])) << (8 * i));
    }
    return value;
  }

  void skip(std::size_t count) { at_ += count; }

 private:
  std::string_view content_;
  std::size_t at_ = 0;
};

// FNV-1a, 64 bits.
std::uint64_t checksum(std::string_view content) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : content) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  }
  return hash;
}

std::uint64_t content_size(std::uint64_t columns, std::uint64_t carried) {
  const std::uint64_t numbers = columns * (columns + 1) / 2 + columns * carried + carried + columns + carried;
  return header_size + 8 * numbers + 8;
}

}  // namespace

namespace detail {

struct StreamingQrFile {
  // Every number of an accumulator, in the order of the file.
  template <typename Qr, typename See>
  static void each_number(Qr& qr, const See& see) {
    auto& state = qr.state_;
    for (Index c = 0; c < qr.columns_ + qr.carried_; ++c) {
      for (Index r = 0; r < std::min(c + 1, qr.columns_); ++r) {
        see(state.triangle(r, c));
      }
    }
    for (auto& norm : state.unreachable) {
      see(norm);
    }
    for (auto& sum : state.sums) {
      see(sum);
    }
  }

  static void put_numbers(const StreamingQr& qr, std::string& out) {
    static_cast<void>(qr.settled());
    each_number(qr, [&](double value) { put(out, value); });
  }

  static StreamingQr with_numbers(Index columns, Index carried, Index rows, Reader& reader) {
    StreamingQr qr(columns, carried);
    qr.rows_ = rows;
    each_number(qr, [&](double& value) { value = std::bit_cast<double>(reader.next<std::uint64_t>()); });
    return qr;
  }
};

}  // namespace detail

std::string encoded(const StreamingQr& qr) {
  const auto columns = static_cast<std::uint64_t>(qr.columns());
  const auto carried = static_cast<std::uint64_t>(qr.carried());
  std::string out(magic);
  out.reserve(content_size(columns, carried));
  put(out, version);
  put(out, byte_order);
  put(out, columns);
  put(out, carried);
  put(out, static_cast<std::uint64_t>(qr.rows()));
  detail::StreamingQrFile::put_numbers(qr, out);
  put(out, checksum(out));
  return out;
}

StreamingQr decoded_streaming_qr(std::string_view content, std::string_view source) {
  const auto fault = [&](const std::string& what) { return InputError(std::string(source) + ": " + what); };
  if (!content.starts_with(magic.substr(0, std::min(magic.size(), content.size()))) || content.empty()) {
    throw fault("is no factor written by rivid; it must start with \"" + std::string(magic) + "\"");
  }
  if (content.size() < header_size) {
    throw fault("is truncated: " + counted(std::ssize(content), "byte") + " of at least " +
                std::to_string(header_size + 8));
  }
  Reader reader(content);
  reader.skip(magic.size());
  const auto its_version = reader.next<std::uint32_t>();
  const auto its_order = reader.next<std::uint32_t>();
  if (its_order != byte_order) {
    throw fault("has its bytes in another order; the format is little-endian");
  }
  if (its_version != version) {
    throw fault("has version " + std::to_string(its_version) + " of the format; this rivid reads version " +
                std::to_string(version));
  }
  const auto columns = reader.next<std::uint64_t>();
  const auto carried = reader.next<std::uint64_t>();
  const auto rows = reader.next<std::uint64_t>();
  if (columns > most_columns || carried > most_columns || carried < 1 || rows >> 62U != 0) {
    throw fault("is damaged: " + std::to_string(columns) + " columns, " + std::to_string(carried) +
                " carried ones, " + std::to_string(rows) + " rows");
  }
  const std::uint64_t size = content_size(columns, carried);
  if (content.size() != size) {
    throw fault((content.size() < size ? "is truncated: " : "is too long: ") +
                counted(std::ssize(content), "byte") + "; with " + std::to_string(columns) + " + " +
                std::to_string(carried) + " columns it must have " + std::to_string(size));
  }
  Reader end(content.substr(content.size() - 8));
  if (end.next<std::uint64_t>() != checksum(content.substr(0, content.size() - 8))) {
    throw fault("is damaged: its checksum does not fit its content");
  }
  return detail::StreamingQrFile::with_numbers(static_cast<Index>(columns), static_cast<Index>(carried),
                                               static_cast<Index>(rows), reader);
}

StreamingQr read_streaming_qr(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream content;
  content << in.rdbuf();
  if (!in.is_open() || std::filesystem::is_directory(path) || content.bad()) {
    throw InputError(path.string() + ": can not be read");
  }
  return decoded_streaming_qr(content.view(), path.string());
}

}  // namespace rivid
