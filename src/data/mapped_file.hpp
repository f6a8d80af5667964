#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace rivid::detail {

/// The bytes of a file, read only. A regular file is mapped, so the text costs no memory of its own and none
/// is copied; a pipe is read to its end.
class MappedFile {
 public:
  /// @throws InputError  where the file is missing, a directory or not readable
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  MappedFile(MappedFile&&) = delete;
  MappedFile& operator=(MappedFile&&) = delete;

  [[nodiscard]] std::string_view bytes() const {
    return mapping_ == nullptr ? std::string_view(content_)
                               : std::string_view(static_cast<const char*>(mapping_), size_);
  }

 private:
  void* mapping_ = nullptr;
  std::size_t size_ = 0;
  std::string content_;
};

}  // namespace rivid::detail
