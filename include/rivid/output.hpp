#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

namespace rivid {

/// The files that one run writes: all of them or none.
///
/// plan() names a file before the work begins and refuses it where writing it would destroy something. put()
/// writes the content to a temporary file in the same folder and flushes it to the disk; commit() renames all
/// of them. A file that is there keeps mode, owner and group, and a symbolic link stays: the file that it
/// points to is replaced. A new file has the mode that the umask leaves. Temporary files that a killed
/// program left in the folder are removed.
///
/// Not for use by several threads at once.
class Outputs {
 public:
  /// @param inputs  files that the run reads, which none of the outputs may be
  /// @param force   replace files of another kind too, see plan()
  explicit Outputs(std::span<const std::filesystem::path> inputs = {}, bool force = false);
  /// What was put and not committed is dropped.
  ~Outputs();
  Outputs(Outputs&& other) noexcept;
  Outputs& operator=(Outputs&& other) = delete;
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;

  /// Nothing is written or made.
  ///
  /// @param extension  of such files, as ".json". An existing file of another extension is only replaced by
  ///                   `force`.
  /// @throws InputError  where the path is an input, was planned already, is there and no regular file,
  ///                     write-protected or of another kind, or where its folder can not be written to
  void plan(const std::filesystem::path& path, std::string_view extension);

  /// Missing folders are made.
  ///
  /// @throws InputError  where the file was not planned or can not be written; what is there is untouched
  void put(const std::filesystem::path& path, std::string_view content);

  /// What was put takes its place.
  ///
  /// @throws InputError  where a file can not be renamed; nothing is lost, the others may be new
  void commit();

 private:
  struct Plan;
  std::unique_ptr<Plan> plan_;
};

/// Writes one file as a whole or not at all, as Outputs does.
///
/// @throws InputError where the place can not be written to; what stood there before is untouched
void write_file(const std::filesystem::path& path, std::string_view content);

/// Whether a file has a name that Outputs give to files that have not taken their place yet.
[[nodiscard]] bool is_temporary_output(const std::filesystem::path& path);

/// Makes SIGINT, SIGTERM and SIGHUP end the program with exit code 128 + signal, without temporary files left
/// behind; not those that were ignored when it started. A write beyond the limit of the file size becomes an
/// error instead of a signal. For main() of a program; may be called in a handler of a signal.
void exit_on_signals();

}  // namespace rivid
