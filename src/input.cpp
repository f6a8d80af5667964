#include "rivid/input.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>
#include <utility>

#include "provided_input.hpp"
#include "rivid/error.hpp"
#include "sha256.hpp"

namespace rivid {

namespace {

constexpr std::uintmax_t most_kept = std::uintmax_t{64} << 20U;  // bytes of an InputScope
constexpr std::size_t megabyte = std::size_t{1} << 20U;          // [bytes]

std::atomic<std::uintmax_t> input_limit{default_input_limit};

class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  ~OpenFile() {
    if (descriptor_ >= 0) {
      ::close(descriptor_);
    }
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  [[nodiscard]] int descriptor() const { return descriptor_; }

  [[nodiscard]] struct stat status() const {
    struct stat out{};
    ::fstat(descriptor_, &out);
    return out;
  }

 private:
  int descriptor_;
};

[[noreturn]] void refuse_input(const std::filesystem::path& path, const std::string& why) {
  throw InputError(path.string() + ": " + why);
}

std::string words_of(int error) { return std::generic_category().message(error); }

bool is_unchanged(const struct stat& before, const struct stat& after) {
  return before.st_size == after.st_size && before.st_mtim.tv_sec == after.st_mtim.tv_sec &&
         before.st_mtim.tv_nsec == after.st_mtim.tv_nsec;
}

}  // namespace

// From malloc(), so that it grows in place and gives pages back.
struct InputText::Content {
  char* bytes = nullptr;
  std::size_t size = 0;
  std::size_t forgotten = 0;

  Content() = default;
  Content(const Content&) = delete;
  Content& operator=(const Content&) = delete;
  ~Content() { std::free(bytes); }

  void reserve(std::size_t capacity) {
    auto* const grown = static_cast<char*>(std::realloc(bytes, capacity));
    if (grown == nullptr) {
      throw std::bad_alloc();
    }
    bytes = grown;
  }

  // To the end of the file.
  void read(const std::filesystem::path& path, const OpenFile& file, std::size_t expected) {
    const std::uintmax_t limit = input_limit;
    std::size_t capacity = expected + 1;
    reserve(capacity);
    while (true) {
      if (size == capacity) {
        capacity += std::max(capacity / 2, megabyte);
        reserve(capacity);
      }
      const ssize_t got = ::read(file.descriptor(), bytes + size, capacity - size);
      if (got == 0) {
        return;
      }
      if (got < 0 && errno != EINTR) {
        refuse_input(path, "can not be read: " + words_of(errno));
      }
      size += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
      if (size > limit) {
        refuse_size(path);
      }
    }
  }

  [[noreturn]] static void refuse_size(const std::filesystem::path& path) {
    refuse_input(path, "has more than " + std::to_string(input_limit / megabyte) +
                           " MiB, the limit of an input; --max-size raises it");
  }
};

namespace {

// What is known of the files of the scope. One mutex for all: a file is read once, whichever thread asks.
struct InputStore {
  struct Entry {
    std::optional<InputText> text;  // empty where there was too much to keep
    std::string sha256;
  };
  std::mutex mutex;
  int scopes = 0;
  std::uintmax_t kept = 0;
  std::map<std::filesystem::path, Entry> entries;
};

InputStore& input_store() {
  static InputStore store;
  return store;
}

constexpr const char* standard_input = "-";

int opened_input(const std::filesystem::path& path, bool pipe) {
  if (pipe && path == standard_input) {
    return ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0);
  }
  // A pipe that nobody writes to must not hold the program up.
  return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
}

void check_kind(const std::filesystem::path& path, const struct stat& status, bool pipe) {
  if (S_ISDIR(status.st_mode)) {
    const std::string name = path.has_filename() ? path.string() : path.parent_path().string();
    refuse_input(path,
                 std::filesystem::exists(path / "metadata.yaml")
                     ? "is the folder of a bag, a CSV file is required; the Python package rivid[ros] makes "
                       "one: rivid convert " +
                           name + " " + name + ".csv"
                     : "is a directory, a file is required");
  }
  const bool is_pipe = S_ISFIFO(status.st_mode) || S_ISSOCK(status.st_mode);
  if (is_pipe && !pipe) {
    refuse_input(path, "is a pipe, a file is required, which can be read more than once");
  }
  if (!is_pipe && !S_ISREG(status.st_mode)) {
    refuse_input(path, "is a device, a file is required");
  }
}

}  // namespace

std::string_view InputText::bytes() const { return {content_->bytes, content_->size}; }

std::string InputText::sha256() const { return rivid::sha256(bytes()); }

void InputText::forget(std::size_t offset) {
  if (content_.use_count() != 1 || offset <= content_->forgotten) {
    return;
  }
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(content_->bytes);
  const std::uintptr_t from = (begin + content_->forgotten + page - 1) / page * page;
  const std::uintptr_t to = (begin + offset) / page * page;
  if (to > from) {
    ::madvise(content_->bytes + (from - begin), to - from, MADV_DONTNEED);
  }
  content_->forgotten = offset;
}

InputText read_input(const std::filesystem::path& path, bool pipe) {
  InputStore& store = input_store();
  std::error_code error;
  const std::filesystem::path key =
      path == standard_input ? path : std::filesystem::absolute(path, error).lexically_normal();
  const std::scoped_lock lock(store.mutex);
  const auto known = store.entries.find(key);
  if (known != store.entries.end() && known->second.text) {
    return *known->second.text;
  }
  const OpenFile file(opened_input(path, pipe));
  if (file.descriptor() < 0) {
    refuse_input(path, errno == ENOENT ? "there is no such file" : "can not be opened: " + words_of(errno));
  }
  const struct stat before = file.status();
  check_kind(path, before, pipe);
  const bool regular = S_ISREG(before.st_mode);
  const auto size = static_cast<std::uintmax_t>(regular ? before.st_size : 0);
  if (size > input_limit) {
    InputText::Content::refuse_size(path);
  }
  ::fcntl(file.descriptor(), F_SETFL, ::fcntl(file.descriptor(), F_GETFL) & ~O_NONBLOCK);
  InputText out(std::make_shared<InputText::Content>());
  out.content_->read(path, file, size);
  if (regular && (!is_unchanged(before, file.status()) || (size > 0 && out.bytes().size() != size))) {
    refuse_input(path, "changed while it was read; read it when no program writes to it");
  }
  if (!regular && out.bytes().empty()) {
    refuse_input(path, "is a pipe that nothing came through");
  }
  if (store.scopes == 0) {
    return out;
  }
  const std::string digest = known == store.entries.end() ? std::string() : out.sha256();
  if (known != store.entries.end() && known->second.sha256 != digest) {
    refuse_input(path, "changed since this program read it; nothing is made of two versions of a file");
  }
  const bool keep = !regular || path == standard_input || store.kept + size <= most_kept;
  store.kept += keep && regular ? size : 0;
  store.entries.insert_or_assign(
      key, keep ? InputStore::Entry{out, {}}
                : InputStore::Entry{std::nullopt, digest.empty() ? out.sha256() : digest});
  return out;
}

void detail::provide_input(const std::filesystem::path& path, std::string_view content) {
  InputText text(std::make_shared<InputText::Content>());
  text.content_->reserve(content.size() + 1);
  std::ranges::copy(content, text.content_->bytes);
  text.content_->size = content.size();
  InputStore& store = input_store();
  const std::scoped_lock lock(store.mutex);
  store.entries.insert_or_assign(path, InputStore::Entry{std::move(text), {}});
}

std::string input_sha256(const std::filesystem::path& path) {
  {
    InputStore& store = input_store();
    std::error_code error;
    const std::scoped_lock lock(store.mutex);
    const auto known = store.entries.find(std::filesystem::absolute(path, error).lexically_normal());
    if (known != store.entries.end() && !known->second.text) {
      return known->second.sha256;
    }
  }
  return read_input(path, true).sha256();
}

std::string sha256(std::string_view text) { return detail::sha256_digits(text); }

void refuse_larger(const std::filesystem::path& path, std::uintmax_t most_bytes) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > most_bytes) {
    refuse_input(path, "has " + std::to_string(size / megabyte) + " MiB, must have at most " +
                           std::to_string(most_bytes / megabyte) + ": it is no file of this kind");
  }
}

void limit_inputs(std::uintmax_t most_bytes) { input_limit = most_bytes; }

InputScope::InputScope() {
  InputStore& store = input_store();
  const std::scoped_lock lock(store.mutex);
  ++store.scopes;
}

InputScope::~InputScope() {
  InputStore& store = input_store();
  const std::scoped_lock lock(store.mutex);
  if (--store.scopes == 0) {
    store.entries.clear();
    store.kept = 0;
  }
}

}  // namespace rivid
