#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace rivid {

namespace detail {
void provide_input(const std::filesystem::path& path, std::string_view content);
}

/// Largest input that is read where limit_inputs() says nothing else [bytes]: 16 GiB.
inline constexpr std::uintmax_t default_input_limit = std::uintmax_t{16} << 30U;

/// Largest URDF, and largest experiment or parameter file in TOML [bytes]; what they become takes a hundred
/// times as much memory.
inline constexpr std::uintmax_t robot_limit = std::uintmax_t{16} << 20U;
/// Largest result, plan or parameter file in JSON, and largest table of parameters [bytes].
inline constexpr std::uintmax_t result_limit = std::uintmax_t{64} << 20U;

/// Refuses a file that is larger, before it is read.
///
/// @throws InputError  where it is
void refuse_larger(const std::filesystem::path& path, std::uintmax_t most_bytes);

/// Sets the largest input that is read from now on [bytes], by all threads.
void limit_inputs(std::uintmax_t most_bytes);

/// The content of a file as it was at one moment: what other programs do with the file does not change it.
class InputText {
 public:
  [[nodiscard]] std::string_view bytes() const;

  /// SHA-256 of bytes(), 64 hexadecimal digits.
  [[nodiscard]] std::string sha256() const;

  /// Gives the memory of bytes()[0, offset) back, unless others use it; it must not be read again.
  void forget(std::size_t offset);

 private:
  friend InputText read_input(const std::filesystem::path& path, bool pipe);
  friend void detail::provide_input(const std::filesystem::path& path, std::string_view content);
  struct Content;
  explicit InputText(std::shared_ptr<Content> content) : content_(std::move(content)) {}
  std::shared_ptr<Content> content_;
};

/// Reads a file once, as a whole. It must be a regular file within the limit of limit_inputs(), and not
/// change meanwhile.
///
/// @param pipe  a pipe may be read to its end as well, and "-" is standard input
/// @throws InputError  where it is missing, can not be read, is no such file, is too large or changes while
///                     it is read
[[nodiscard]] InputText read_input(const std::filesystem::path& path, bool pipe = false);

/// SHA-256 of a file, 64 hexadecimal digits: of the content that read_input() gave, where an InputScope
/// lives.
///
/// @throws InputError  where read_input() of a file or pipe throws it
[[nodiscard]] std::string input_sha256(const std::filesystem::path& path);

/// SHA-256 of a text, 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view text);

/// As long as one lives, read_input() gives the same content for the same path whenever it is asked: all that
/// a run reads, computes from, writes the digest of and draws is of one moment. Up to 64 MiB of files, and
/// all pipes, are kept in memory. Of what is beyond that the digest is kept: a file that is read again and
/// has another one is refused.
class InputScope {
 public:
  InputScope();
  ~InputScope();
  InputScope(const InputScope&) = delete;
  InputScope& operator=(const InputScope&) = delete;
};

}  // namespace rivid
