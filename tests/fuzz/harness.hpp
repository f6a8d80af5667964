#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "provided_input.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "support/temporary_folder.hpp"

// A harness is one file of this folder: LLVMFuzzerTestOneInput() gives bytes to a reader and checks what
// comes out. With the preset `fuzz` libFuzzer calls it, else replay.cpp does, with each file of
// corpus/<harness>.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace rivid::fuzz {

/// Ends the program where a claim does not hold: the input is a finding.
inline void require(bool holds, std::string_view claim) {
  if (!holds) {
    std::fprintf(stderr, "does not hold: %.*s\n", static_cast<int>(claim.size()), claim.data());
    std::abort();
  }
}

/// What a reader makes of an input; nothing where it refuses the input in words. Any other exception is a
/// finding.
template <typename Read>
[[nodiscard]] auto accepted(const Read& read) {
  std::optional<decltype(read())> out;
  try {
    out.emplace(read());
  } catch (const Error& e) {
    require(std::string_view(e.what()).find('\n') == std::string_view::npos, "a message has one line");
  }
  return out;
}

/// What a reader makes of a text that this library wrote, which it must not refuse.
template <typename Read>
[[nodiscard]] auto read_back(std::string_view claim, const Read& read) {
  try {
    return read();
  } catch (const Error& e) {
    require(false, std::string(claim) + ": " + e.what());
    throw;
  }
}

/// The bytes of an input in turn.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(reinterpret_cast<const char*>(data), size) {}

  /// One of `count` cases, by the next byte: the letters from 'a' on, so that a corpus can be read. 0 at the
  /// end.
  [[nodiscard]] std::size_t choice(std::size_t count) {
    if (rest_.empty()) {
      return 0;
    }
    const auto letter = static_cast<unsigned char>(rest_.front());
    rest_.remove_prefix(1);
    return static_cast<unsigned char>(letter - 'a') % count;
  }

  /// The bytes before the next line "=====", or all that there are: one file of several.
  [[nodiscard]] std::string_view file() {
    constexpr std::string_view end = "\n=====\n";
    const std::size_t at = rest_.find(end);
    const std::string_view out = rest_.substr(0, at);
    rest_.remove_prefix(at == std::string_view::npos ? rest_.size() : at + end.size());
    return out;
  }

  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

/// The folder for the files of a harness, one for all inputs.
inline const test::TemporaryFolder& folder() {
  static const test::TemporaryFolder out;
  return out;
}

/// Path in folder() that is read with this content. The file that is there is empty: no input is written to a
/// disk.
inline std::filesystem::path file_with(std::string_view content, const std::string& name) {
  static const InputScope scope;
  std::filesystem::path path = folder().path() / name;
  if (!std::filesystem::exists(path)) {
    folder().write(name, "");
  }
  detail::provide_input(path, content);
  return path;
}

/// FNV-1a, 64 bits: the checksum of files whose damage must be seen. A harness puts in the right one, lest no
/// input came further than that.
[[nodiscard]] inline std::uint64_t fnv1a(std::string_view bytes) {
  std::uint64_t sum = 0xCBF29CE484222325U;
  for (const char c : bytes) {
    sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  }
  return sum;
}

/// Puts the right checksum over the last eight bytes; little-endian, as the machines that fuzz are.
inline void put_checksum(std::string& bytes) {
  const std::size_t end = bytes.size() - sizeof(std::uint64_t);
  const std::uint64_t sum = fnv1a(std::string_view(bytes).substr(0, end));
  std::memcpy(bytes.data() + end, &sum, sizeof(sum));
}

}  // namespace rivid::fuzz
