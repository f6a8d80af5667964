#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "support/temporary_folder.hpp"

namespace rivid::test {

/// What a program left behind.
struct Outcome {
  int exit_code = -1;  ///< −1 where a signal ended it
  int signal = 0;      ///< that ended it, else 0
  std::string out;     ///< standard output
  std::string err;     ///< standard error
};

/// A running program. Its standard input is empty; what it prints is kept in files, so it never waits for a
/// reader.
class Process {
 public:
  /// @param command  path of the program, then its arguments
  /// @param folder   working directory
  Process(std::vector<std::string> command, const std::filesystem::path& folder,
          const std::filesystem::path& out = {}) {
    const std::filesystem::path out_file = out.empty() ? prints_.path() / "out" : out;
    const std::filesystem::path err_file = prints_.path() / "err";
    posix_spawn_file_actions_t actions{};
    ::posix_spawn_file_actions_init(&actions);
    constexpr int writing = O_WRONLY | O_CREAT | O_TRUNC;
    constexpr mode_t mode = 0600;
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_file.c_str(), writing, mode);
    ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err_file.c_str(), writing, mode);
    ::posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    std::vector<char*> arguments;
    for (std::string& argument : command) {
      arguments.push_back(argument.data());
    }
    arguments.push_back(nullptr);
    const int error = ::posix_spawn(&id_, arguments[0], &actions, nullptr, arguments.data(), ::environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
      throw std::runtime_error("can not start " + command[0] + ": " + std::generic_category().message(error));
    }
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  Process(Process&&) = delete;
  Process& operator=(Process&&) = delete;
  ~Process() {
    if (id_ > 0) {
      ::kill(id_, SIGKILL);
      ::waitpid(id_, nullptr, 0);
    }
  }

  void send(int signal) const { ::kill(id_, signal); }

  [[nodiscard]] Outcome wait() {
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = 0;
    Outcome outcome;
    outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    outcome.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (std::filesystem::exists(prints_.path() / "out")) {
      outcome.out = prints_.read("out");
    }
    outcome.err = prints_.read("err");
    return outcome;
  }

 private:
  TemporaryFolder prints_;
  pid_t id_ = 0;
};

/// Runs a program to its end.
inline Outcome outcome_of(std::vector<std::string> command, const std::filesystem::path& folder) {
  return Process(std::move(command), folder).wait();
}

}  // namespace rivid::test
