// A library for LD_PRELOAD that lets one system call fail. RIVID_FAULT is "call:error:which": the call write,
// read, fsync, open or rename; the error ENOSPC, EIO, EINTR or SHORT (half of the bytes are written or read);
// the how many-th call, from 1. Where the fault happens, the file RIVID_FAULT_MARK is made.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

struct Fault {
  char call[16] = "";
  char error[16] = "";
  int which = 0;

  Fault() {
    if (const char* const text = std::getenv("RIVID_FAULT")) {
      std::sscanf(text, "%15[^:]:%15[^:]:%d", call, error, &which);
    }
  }
};

std::atomic<int> calls{0};

template <typename Function>
Function* next(const char* name) {
  void* const found = ::dlsym(RTLD_NEXT, name);
  Function* out = nullptr;
  std::memcpy(&out, &found, sizeof out);
  return out;
}

int real_open(const char* path, int flags, mode_t mode) {
  static auto* const call = next<int(const char*, int, ...)>("open");
  return call(path, flags, mode);
}

// The error of this call; 0: none, −1: short.
int fault_of(const char* call) {
  static const Fault fault;
  if (std::strcmp(call, fault.call) != 0 || ++calls != fault.which) {
    return 0;
  }
  if (const char* const mark = std::getenv("RIVID_FAULT_MARK")) {
    ::close(real_open(mark, O_WRONLY | O_CREAT, 0600));
  }
  constexpr struct {
    const char* name;
    int value;
  } errors[] = {{"ENOSPC", ENOSPC}, {"EIO", EIO}, {"EINTR", EINTR}, {"SHORT", -1}};
  for (const auto& error : errors) {
    if (std::strcmp(error.name, fault.error) == 0) {
      return error.value;
    }
  }
  return EIO;
}

bool fails(int error) {
  if (error > 0) {
    errno = error;
  }
  return error > 0;
}

}  // namespace

extern "C" {

ssize_t write(int file, const void* data, std::size_t size) {
  static auto* const call = next<ssize_t(int, const void*, std::size_t)>("write");
  const int error = fault_of("write");
  return fails(error) ? -1 : call(file, data, error < 0 && size > 1 ? size / 2 : size);
}

ssize_t read(int file, void* data, std::size_t size) {
  static auto* const call = next<ssize_t(int, void*, std::size_t)>("read");
  const int error = fault_of("read");
  return fails(error) ? -1 : call(file, data, error < 0 && size > 1 ? size / 2 : size);
}

int fsync(int file) {
  static auto* const call = next<int(int)>("fsync");
  return fails(fault_of("fsync")) ? -1 : call(file);
}

int rename(const char* from, const char* to) noexcept {
  static auto* const call = next<int(const char*, const char*)>("rename");
  return fails(fault_of("rename")) ? -1 : call(from, to);
}

int open(const char* path, int flags, ...) {
  mode_t mode = 0;
  if ((flags & O_CREAT) != 0) {
    va_list arguments;
    va_start(arguments, flags);
    mode = va_arg(arguments, mode_t);
    va_end(arguments);
  }
  return fails(fault_of("open")) ? -1 : real_open(path, flags, mode);
}

}  // extern "C"
