#include "mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "rivid/error.hpp"

namespace rivid::detail {

namespace {

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) {
      ::close(value_);
    }
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor(Descriptor&&) = delete;
  Descriptor& operator=(Descriptor&&) = delete;
  [[nodiscard]] int value() const { return value_; }

 private:
  int value_;
};

std::string reason(int error) { return std::generic_category().message(error); }

std::string read_to_end(int descriptor, const std::string& name) {
  std::string content;
  std::array<char, 65536> buffer{};
  while (true) {
    const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
    if (got == 0) {
      return content;
    }
    if (got > 0) {
      content.append(buffer.data(), static_cast<std::size_t>(got));
    } else if (errno != EINTR) {
      throw InputError(name + ": can not be read: " + reason(errno));
    }
  }
}

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path) {
  const std::string name = path.string();
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.value() < 0) {
    throw InputError(name + ": " +
                     (errno == ENOENT ? "there is no such file" : "can not be opened: " + reason(errno)));
  }
  struct stat status{};
  if (::fstat(file.value(), &status) != 0) {
    throw InputError(name + ": can not be read: " + reason(errno));
  }
  if (S_ISDIR(status.st_mode)) {
    throw InputError(name + ": is a directory, a file is required");
  }
  if (S_ISREG(status.st_mode) && status.st_size > 0) {
    size_ = static_cast<std::size_t>(status.st_size);
    void* const mapping = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file.value(), 0);
    if (mapping != MAP_FAILED) {
      mapping_ = mapping;
      ::madvise(mapping_, size_, MADV_SEQUENTIAL);
      return;
    }
  }
  content_ = read_to_end(file.value(), name);
}

MappedFile::~MappedFile() {
  if (mapping_ != nullptr) {
    ::munmap(mapping_, size_);
  }
}

}  // namespace rivid::detail
