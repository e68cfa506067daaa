// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/line_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <thread>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/no_sigpipe.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/files/files.hpp"

extern char** environ;

namespace estancia {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t tail = 4096;            // bytes kept of stderr
constexpr milliseconds grace{500};            // to end by itself once its stdin is closed
constexpr milliseconds betweenLooks{50};      // whether it lives, while a child of it keeps its stdout open
constexpr milliseconds betweenQuickLooks{2};  // while it is about to end

void closeEnd(int& fd) {
  if (fd >= 0) ::close(std::exchange(fd, -1));
}

/// A pipe that no other child inherits, with both ends above stdin, stdout and stderr, which may be closed.
struct Pipe {
  int read = -1, write = -1;

  explicit Pipe(ErrorCode problem) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) fail(problem, "cannot make a pipe: {}", std::strerror(errno));
    read = above(ends[0]);
    write = above(ends[1]);
  }
  ~Pipe() {
    closeEnd(read);
    closeEnd(write);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

 private:
  static int above(int fd) {
    if (fd > STDERR_FILENO) return fd;
    const int moved = fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    ::close(fd);
    return moved;
  }
};

/// One bufferful, so that the limits and the clock are looked at again soon.
void readSome(int& end, std::string& text) {
  std::array<char, 65536> buffer;
  const ssize_t count = ::read(end, buffer.data(), buffer.size());
  if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
  if (count == 0) closeEnd(end);
}

int ours(int& end) {
  fcntl(end, F_SETFL, O_NONBLOCK);
  return std::exchange(end, -1);
}

std::string howItEnded(int status) {
  if (WIFEXITED(status)) return fmt::format("exit status {}", WEXITSTATUS(status));
  return fmt::format("signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
}

/// Limits a faulty program: no more memory than the machine has, and no core dumps. If memory runs out all
/// the same, the kernel kills it rather than this process, which may be writing a map.
void limit(pid_t pid) {
  const auto memory =
      static_cast<rlim_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
  const rlimit none{0, 0}, all{memory, memory};
  prlimit(pid, RLIMIT_CORE, &none, nullptr);
  prlimit(pid, RLIMIT_DATA, &all, nullptr);
  std::ofstream(fmt::format("/proc/{}/oom_score_adj", pid)) << 1000;
}

/// Without reaping it, so that its number, and its group's, stay its own.
bool hasEnded(pid_t pid) {
  siginfo_t info{};
  return waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid == pid;
}

/// Reads the child's number, then waits for the end of the file. The guard is in the group itself, so that no
/// other process has its number. The child may lead a group of its own by now (setsid), or not have started.
constexpr const char* guardScript = "read -r child; read -r end; kill -KILL ${child:+$child -$child} 0";

/// Runs the guard with all signals blocked: what stops or ends the group by name must not end it.
int spawnGuard(int input, pid_t& guard) {
  std::string shell = "sh", option = "-c", script = guardScript;
  const std::array<char*, 4> arguments{shell.data(), option.data(), script.data(), nullptr};
  const std::array<char*, 1> environment{nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  posix_spawnattr_t how;
  posix_spawnattr_init(&how);
  sigset_t all;
  sigfillset(&all);
  posix_spawnattr_setpgroup(&how, 0);
  posix_spawnattr_setsigmask(&how, &all);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  const int problem = posix_spawn(&guard, "/bin/sh", &actions, &how, arguments.data(), environment.data());
  posix_spawnattr_destroy(&how);
  posix_spawn_file_actions_destroy(&actions);
  return problem;
}

}  // namespace

ProcessGroup::ProcessGroup() {
  Pipe pipe(ErrorCode::labelerFailure);
  const int problem = pipe.read < 0 || pipe.write < 0 ? EMFILE : spawnGuard(pipe.read, guard_);
  if (problem == 0) {
    lifeline_ = std::exchange(pipe.write, -1);
    return;
  }
  fail(ErrorCode::labelerFailure,
       "cannot run /bin/sh ({}), which ends label programs with Estancia; install it",
       std::strerror(problem));
}

void ProcessGroup::include(pid_t child) {
  const std::string line = fmt::format("{}\n", child);
  const NoSigpipe quiet;  // should the guard be gone
  [[maybe_unused]] const ssize_t written = ::write(lifeline_, line.data(), line.size());
}

void ProcessGroup::kill() {
  if (guard_ < 0) return;
  ::kill(-guard_, SIGKILL);
  ::close(std::exchange(lifeline_, -1));
  while (waitpid(guard_, nullptr, 0) < 0 && errno == EINTR) continue;
  guard_ = -1;
}

LineProcess::LineProcess(const Settings& settings) : maxLine_(settings.maxLine) {
  Pipe in(ErrorCode::busy), out(ErrorCode::busy), err(ErrorCode::busy);
  std::vector<std::string> words = settings.command;
  if (words[0].find('/') == std::string::npos && fs::is_regular_file(settings.folder / words[0]))
    words[0].insert(0, "./");
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in.read, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out.write, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.write, STDERR_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  posix_spawn_file_actions_addchdir_np(&actions, settings.folder.c_str());
  posix_spawnattr_t how;
  posix_spawnattr_init(&how);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setpgroup(&how, group_.id());  // not ours: Ctrl-C is ours, and we end all of it
  posix_spawnattr_setsigmask(&how, &none);
  posix_spawnattr_setsigdefault(&how, &all);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  const int problem = posix_spawnp(&pid_, arguments[0], &actions, &how, arguments.data(), environ);
  posix_spawnattr_destroy(&how);
  posix_spawn_file_actions_destroy(&actions);
  if (problem != 0)
    fail(ErrorCode::missingDependency, "{} cannot be started: {}; correct `command` in model.toml",
         io::printable(words[0]), std::strerror(problem));
  group_.include(pid_);
  limit(pid_);
  input_ = ours(in.write);
  output_ = ours(out.read);
  complaints_ = ours(err.read);
}

LineProcess::~LineProcess() {
  finish(grace);
}

LineProcess::Outcome LineProcess::ask(std::string_view question, milliseconds timeout, std::string& answer) {
  const auto deadline = Clock::now() + timeout;
  if (pid_ < 0) return Outcome::ended;
  readSome(output_, pending_);
  if (!pending_.empty())
    fail(ErrorCode::labelerFailure,
         "wrote \"{}\" to stdout without being asked; write nothing there but the answers",
         io::printable(std::string_view(pending_).substr(0, 80)));
  const std::string line = std::string(question) + '\n';
  std::string_view rest = line;
  while (true) {
    if (takeLine(answer)) return Outcome::answered;
    if (pending_.size() > maxLine_)
      fail(ErrorCode::labelerFailure, "wrote a line of more than {} bytes; an answer is one line of JSON",
           maxLine_);
    const bool gone = output_ < 0 || hasEnded(pid_);
    if (gone) {
      const bool closed = output_ < 0;
      if (!closed) readSome(output_, pending_);  // a pipe holds no more than it reads
      if (takeLine(answer)) return Outcome::answered;
      finish(grace);
      if (closed && end_ == "killed") end_ = "it closed its stdout, went on, and was killed";
      return Outcome::ended;
    }
    if (interrupted()) {
      finish(milliseconds(0));
      throw Interrupted("stopped while the program was at work");
    }
    const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) {
      finish(milliseconds(0));
      return Outcome::hung;
    }
    std::array<pollfd, 3> ends{
        {{rest.empty() ? -1 : input_, POLLOUT, 0}, {output_, POLLIN, 0}, {complaints_, POLLIN, 0}}};
    ::poll(ends.data(), ends.size(), static_cast<int>(std::min(left, betweenLooks).count()));
    if (ends[0].revents != 0) write(rest);
    if (ends[1].revents != 0) readSome(output_, pending_);
    if (ends[2].revents != 0) readComplaints();
  }
}

bool LineProcess::takeLine(std::string& line) {
  const auto end = pending_.find('\n', searched_);
  searched_ = pending_.size();
  if (end == std::string::npos) return false;
  line = pending_.substr(0, end);
  if (line.ends_with('\r')) line.pop_back();
  pending_.erase(0, end + 1);
  searched_ = 0;
  return true;
}

void LineProcess::readComplaints() {
  readSome(complaints_, complaintsTail_);
  if (complaintsTail_.size() > tail) complaintsTail_.erase(0, complaintsTail_.size() - tail);
}

void LineProcess::write(std::string_view& rest) {
  const NoSigpipe quiet;
  const ssize_t count = ::write(input_, rest.data(), rest.size());
  if (count > 0) rest.remove_prefix(static_cast<std::size_t>(count));
  // it reads no more; its output will show why
  if (count < 0 && errno != EAGAIN && errno != EINTR) rest = {};
}

/// Closes its input, gives it `patience` to end, then kills what is left of its group.
void LineProcess::finish(milliseconds patience) {
  if (pid_ < 0) return;
  closeEnd(input_);
  const auto deadline = Clock::now() + patience;
  while (!hasEnded(pid_) && Clock::now() < deadline) {
    if (output_ >= 0) readSome(output_, pending_);  // a full pipe would keep it from ending
    pending_.clear();
    if (complaints_ >= 0) readComplaints();
    std::this_thread::sleep_for(betweenQuickLooks);
  }
  const bool byItself = hasEnded(pid_);
  group_.kill();
  ::kill(pid_, SIGKILL);  // it may have left the group, for one of its own
  ::kill(-pid_, SIGKILL);
  int status = 0;
  pid_t reaped = -1;
  do reaped = waitpid(pid_, &status, 0);
  while (reaped < 0 && errno == EINTR);
  end_ = !byItself ? "killed" : reaped == pid_ ? howItEnded(status) : "it ended";
  pid_ = -1;
  for (int i = 0; complaints_ >= 0 && i < 16; ++i) readComplaints();  // its last words
  closeEnd(output_);
  closeEnd(complaints_);
}

std::string LineProcess::lastWords() const {
  constexpr std::size_t maxText = 300;
  std::string_view text = complaintsTail_;
  const auto last = text.find_last_not_of(" \t\r\n");
  if (last == std::string_view::npos) return "";
  text = text.substr(0, last + 1);
  if (text.size() > maxText) text = text.substr(text.size() - maxText);
  std::string words;
  for (const char c : text) {  // one line
    if (c == '\n' && !words.ends_with(" | ")) words += " | ";
    if (c != '\n' && c != '\r') words += c;
  }
  return io::printable(words);
}

}  // namespace estancia
