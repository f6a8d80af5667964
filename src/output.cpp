#include "rivid/output.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using Path = std::filesystem::path;
using FileStatus = struct stat;

// Names of temporary files that a signal has to remove. A handler may neither allocate nor wait, so they have
// places of their own. `busy` is held while the names change or files are renamed; a signal that comes then
// is kept until it is let go.
constexpr std::size_t most_temporaries = 16;
std::array<std::array<char, PATH_MAX>, most_temporaries> temporary_names{};
std::atomic_flag busy;
std::atomic<int> pending_signal{0};

[[noreturn]] void end_by_signal(int signal) {
  for (const auto& name : temporary_names) {
    if (name[0] != '\0') {
      ::unlink(name.data());
    }
  }
  constexpr int first_code = 128;  // of exits by a signal, as shells count them
  ::_exit(first_code + signal);
}

void on_signal(int signal) {
  do {
    if (!busy.test_and_set()) {
      end_by_signal(signal);
    }
    pending_signal = signal;
  } while (!busy.test());
}

class SignalsHeld {
 public:
  SignalsHeld() {
    while (busy.test_and_set()) {
    }
  }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;
  ~SignalsHeld() {
    busy.clear();
    if (const int signal = pending_signal; signal != 0) {
      end_by_signal(signal);
    }
  }
};

std::string error_text(int error) { return std::generic_category().message(error); }

[[noreturn]] void refuse_write(const Path& path, int error) {
  throw InputError(path.string() + ": can not be written: " + error_text(error));
}

std::optional<FileStatus> status_of(const Path& path) {
  FileStatus status{};
  return ::stat(path.c_str(), &status) == 0 ? std::optional(status) : std::nullopt;
}

bool is_same(const FileStatus& a, const FileStatus& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

// The file that a path leads to: links of the last component followed even where the end of them is missing.
Path followed(const Path& named) {
  Path path = named;
  constexpr int most_links = 40;  // as Linux follows
  std::error_code error;
  for (int i = 0; i < most_links && std::filesystem::is_symlink(path, error); ++i) {
    const Path to = std::filesystem::read_symlink(path, error);
    path = to.is_absolute() ? to : path.parent_path() / to;
  }
  const Path folder = path.parent_path().empty() ? Path(".") : path.parent_path();
  error.clear();
  const Path absolute = std::filesystem::absolute(folder, error);
  const Path out = error ? Path() : std::filesystem::weakly_canonical(absolute, error);
  if (error) {
    refuse_write(named, error.value());
  }
  return out / path.filename();
}

constexpr std::string_view temporary_prefix = ".rivid-";
constexpr std::size_t temporary_letters = 6;  // of 32: a thousand million names

std::string temporary_name() {
  static constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz234567";
  std::random_device random;
  std::string name(temporary_prefix);
  for (std::size_t i = 0; i < temporary_letters; ++i) {
    name += letters[random() % letters.size()];
  }
  return name;
}

// Who writes a temporary file holds a lock on it: one without a lock belongs to a program that was killed.
void sweep(const Path& folder) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (!is_temporary_output(entry.path())) {
      continue;
    }
    const int file = ::open(entry.path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    FileStatus status{};
    if (file >= 0 && ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() &&
        ::flock(file, LOCK_EX | LOCK_NB) == 0) {
      ::unlink(entry.path().c_str());
    }
    if (file >= 0) {
      ::close(file);
    }
  }
}

}  // namespace

namespace detail {

// A temporary file, removed unless it takes the place of its target.
class StagedFile {
 public:
  StagedFile(const Path& target, const std::optional<FileStatus>& replaced) {
    constexpr mode_t of_a_new_file = 0666;
    constexpr mode_t until_it_is_whole = 0600;
    const mode_t mode = replaced ? until_it_is_whole : of_a_new_file;
    constexpr int most_attempts = 100;  // any number: names that all exist are no chance
    for (int i = 0; i < most_attempts && descriptor_ < 0; ++i) {
      name_ = (target.parent_path() / temporary_name()).string();
      hold();
      descriptor_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
      if (descriptor_ < 0) {
        let_go();
        if (errno != EEXIST) {
          return;
        }
      } else if (!is_locked()) {
        remove();
      }
    }
  }
  StagedFile(StagedFile&& other) noexcept
      : name_(std::move(other.name_)),
        descriptor_(std::exchange(other.descriptor_, -1)),
        slot_(std::exchange(other.slot_, most_temporaries)) {}
  StagedFile& operator=(StagedFile&&) = delete;
  StagedFile(const StagedFile&) = delete;
  StagedFile& operator=(const StagedFile&) = delete;
  ~StagedFile() {
    if (descriptor_ >= 0) {
      remove();
    }
  }

  [[nodiscard]] bool opened() const { return descriptor_ >= 0; }

  [[nodiscard]] bool write(std::string_view content) const {
    while (!content.empty()) {
      const ssize_t written = ::write(descriptor_, content.data(), content.size());
      if (written < 0 && errno == EINTR) {
        continue;
      }
      if (written <= 0) {
        errno = written == 0 ? ENOSPC : errno;
        return false;
      }
      content.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
  }

  [[nodiscard]] bool flush() const {
    int done = 0;
    do {
      done = ::fsync(descriptor_);
    } while (done != 0 && errno == EINTR);
    return done == 0;
  }

  [[nodiscard]] bool take_owner_and_mode(const FileStatus& from) const {
    FileStatus own{};
    constexpr mode_t permissions = 07777;
    return ::fstat(descriptor_, &own) == 0 &&
           ((own.st_uid == from.st_uid && own.st_gid == from.st_gid) ||
            ::fchown(descriptor_, from.st_uid, from.st_gid) == 0) &&
           ::fchmod(descriptor_, from.st_mode & permissions) == 0;
  }

  // Within SignalsHeld.
  [[nodiscard]] bool become(const Path& target) {
    if (::rename(name_.c_str(), target.c_str()) != 0) {
      return false;
    }
    clear_slot();
    ::close(std::exchange(descriptor_, -1));
    return true;
  }

 private:
  // Whether the file is still there when the lock is held; a program that sweeps may have been quicker.
  [[nodiscard]] bool is_locked() const {
    FileStatus status{};
    return ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 && ::fstat(descriptor_, &status) == 0 &&
           status.st_nlink > 0;
  }

  void hold() {
    const SignalsHeld signals_held;
    for (slot_ = 0; slot_ < most_temporaries && temporary_names[slot_][0] != '\0';) {
      ++slot_;
    }
    if (slot_ < most_temporaries && name_.size() < PATH_MAX) {
      std::ranges::copy(name_, temporary_names[slot_].begin());
      temporary_names[slot_][name_.size()] = '\0';
    }
  }

  void clear_slot() {
    if (slot_ < most_temporaries) {
      temporary_names[slot_][0] = '\0';
      slot_ = most_temporaries;
    }
  }

  void let_go() {
    const int error = errno;
    const SignalsHeld signals_held;
    clear_slot();
    errno = error;
  }

  void remove() {
    const int error = errno;
    ::unlink(name_.c_str());
    ::close(std::exchange(descriptor_, -1));
    let_go();
    errno = error;
  }

  std::string name_;
  int descriptor_ = -1;
  std::size_t slot_ = most_temporaries;
};

}  // namespace detail

namespace {

// The nearest folder above a file that is there must let files be made in it.
void check_folder(const Path& named, Path folder) {
  std::error_code error;
  while (!std::filesystem::exists(folder, error) && folder.has_relative_path()) {
    folder = folder.parent_path();
  }
  if (!std::filesystem::is_directory(folder, error)) {
    refuse_write(named, ENOTDIR);
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    refuse_write(named, errno);
  }
}

void check_replaced(const Path& named, const Path& target, const FileStatus& status) {
  if (S_ISDIR(status.st_mode)) {
    throw InputError(named.string() + ": can not be written: " + error_text(EISDIR));
  }
  if (!S_ISREG(status.st_mode)) {
    throw InputError(named.string() + ": is no regular file; a pipe or device is not written to");
  }
  if (::access(target.c_str(), W_OK) != 0) {
    refuse_write(named, errno);
  }
}

void flush_folder(const Path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0) {
    ::fsync(descriptor);  // where the file system can not, the rename is as durable as it gets
    ::close(descriptor);
  }
}

}  // namespace

struct Outputs::Plan {
  struct File {
    Path named;
    Path target;
    std::optional<detail::StagedFile> staged;
  };
  std::vector<Path> inputs;
  bool force = false;
  std::vector<File> files;

  File* find(const Path& named) {
    const auto at = std::ranges::find(files, named, &File::named);
    return at == files.end() ? nullptr : &*at;
  }
};

Outputs::Outputs(std::span<const std::filesystem::path> inputs, bool force)
    : plan_(std::make_unique<Plan>()) {
  plan_->inputs.assign(inputs.begin(), inputs.end());
  plan_->force = force;
}

Outputs::Outputs(Outputs&& other) noexcept = default;

Outputs::~Outputs() = default;

void Outputs::plan(const std::filesystem::path& path, std::string_view extension) {
  if (!path.has_filename()) {
    throw InputError(path.string() + ": names a folder, a file is required");
  }
  const Path target = followed(path);
  const std::optional<FileStatus> there = status_of(target);
  if (there) {
    check_replaced(path, target, *there);
    for (const Path& input : plan_->inputs) {
      const std::optional<FileStatus> status = status_of(input);
      if (status && is_same(*there, *status)) {
        throw InputError(path.string() + ": is an input of this run" +
                         (input == path ? "" : " (" + input.string() + ")") +
                         ", which is not overwritten; name another file");
      }
    }
  }
  for (const Plan::File& other : plan_->files) {
    const std::optional<FileStatus> status = there ? status_of(other.target) : std::nullopt;
    if (other.target == target || (status && is_same(*there, *status))) {
      throw InputError(path.string() + ": is written twice in this run" +
                       (other.named == path ? "" : ", as " + other.named.string() + " too") +
                       "; give each output a name of its own");
    }
  }
  if (there && !plan_->force && target.extension() != extension) {
    throw InputError(path.string() + ": is there already and is no " + std::string(extension) +
                     " file; name another file, or --force writes over it");
  }
  check_folder(path, target.parent_path());
  plan_->files.push_back({path, target, std::nullopt});
}

void Outputs::put(const std::filesystem::path& path, std::string_view content) {
  Plan::File* const file = plan_->find(path);
  if (file == nullptr) {
    throw InputError("Outputs: " + path.string() + " was not planned");
  }
  std::error_code error;
  const Path folder = file->target.parent_path();
  std::filesystem::create_directories(folder, error);
  const std::optional<FileStatus> there = status_of(file->target);
  detail::StagedFile staged(file->target, there);
  if (!staged.opened() || !staged.write(content)) {
    refuse_write(path, errno);
  }
  if (there && !staged.take_owner_and_mode(*there)) {
    throw InputError(path.string() + ": its owner and mode can not be kept: " + error_text(errno) +
                     "; remove it first, or name another file");
  }
  if (!staged.flush()) {
    refuse_write(path, errno);
  }
  file->staged.emplace(std::move(staged));
}

void Outputs::commit() {
  std::set<Path> folders;
  const Plan::File* failed = nullptr;
  int error = 0;
  for (const Plan::File& file : plan_->files) {
    if (const auto there = file.staged ? status_of(file.target) : std::nullopt) {
      check_replaced(file.named, file.target, *there);
    }
  }
  {
    const SignalsHeld signals_held;
    for (Plan::File& file : plan_->files) {
      if (!file.staged) {
        continue;
      }
      if (!file.staged->become(file.target)) {
        failed = &file;
        error = errno;
        break;
      }
      folders.insert(file.target.parent_path());
    }
  }
  std::ranges::for_each(folders, flush_folder);
  // Only now: where the run before was killed, its document that waits says whose the tables are.
  std::ranges::for_each(folders, sweep);
  if (failed != nullptr) {
    refuse_write(failed->named, error);
  }
  plan_->files.clear();
}

bool is_temporary_output(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '2' && c <= '7'); };
  return name.size() == temporary_prefix.size() + temporary_letters && name.starts_with(temporary_prefix) &&
         std::all_of(name.begin() + temporary_prefix.size(), name.end(), is_letter);
}

void write_file(const std::filesystem::path& path, std::string_view content) {
  Outputs one({}, true);
  one.plan(path, {});
  one.put(path, content);
  one.commit();
}

void exit_on_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before{};
    ::sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) {
      struct sigaction action{};
      action.sa_handler = on_signal;
      action.sa_flags = SA_RESTART;
      ::sigaction(signal, &action, nullptr);
    }
  }
  std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace rivid
