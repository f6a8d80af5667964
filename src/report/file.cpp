#include "rivid/report/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
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

// An interruption waits until the file is whole, so that it leaves no temporary file behind.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t held;
    ::sigemptyset(&held);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
      ::sigaddset(&held, signal);
    }
    ::pthread_sigmask(SIG_BLOCK, &held, &before_);
  }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;
  ~SignalsHeld() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_{};
};

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view content) {
  std::error_code error;
  if (path.has_parent_path()) {
    std::filesystem::create_directories(path.parent_path(), error);
  }
  const SignalsHeld signals_held;
  TemporaryFile file(path);
  if (!file.opened() || !file.write(content) || !file.become(path)) {
    throw InputError(path.string() + ": can not be written: " + std::strerror(errno));
  }
}

}  // namespace rivid
