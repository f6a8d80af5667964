#include "rivid/report/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "rivid/error.hpp"

namespace rivid {

namespace {

// A file descriptor that is closed, and a file that is removed, unless the write went through.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& target)
      : name_(target.string() + ".XXXXXX"), descriptor_(::mkstemp(name_.data())) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_ >= 0) {
      ::close(descriptor_);
      ::unlink(name_.c_str());
    }
  }

  [[nodiscard]] bool write(std::string_view content) const {
    while (!content.empty()) {
      const ssize_t written = ::write(descriptor_, content.data(), content.size());
      if (written < 0 && errno == EINTR) {
        continue;
      }
      if (written <= 0) {
        return false;
      }
      content.remove_prefix(static_cast<std::size_t>(written));
    }
    constexpr mode_t readable_by_all = 0644;
    return ::fchmod(descriptor_, readable_by_all) == 0 && ::fsync(descriptor_) == 0;
  }

  [[nodiscard]] bool opened() const { return descriptor_ >= 0; }

  [[nodiscard]] bool become(const std::filesystem::path& target) {
    const bool closed = ::close(descriptor_) == 0;
    descriptor_ = -1;
    if (closed && ::rename(name_.c_str(), target.c_str()) == 0) {
      return true;
    }
    ::unlink(name_.c_str());
    return false;
  }

 private:
  std::string name_;
  int descriptor_;
};

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view content) {
  std::error_code error;
  if (path.has_parent_path()) {
    std::filesystem::create_directories(path.parent_path(), error);
  }
  TemporaryFile file(path);
  if (!file.opened() || !file.write(content) || !file.become(path)) {
    throw InputError(path.string() + ": can not be written: " + std::strerror(errno));
  }
}

}  // namespace rivid
