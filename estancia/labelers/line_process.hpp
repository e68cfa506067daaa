// Line process: a child program that answers each line on its stdin with a line on its stdout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace estancia {

/// The leader of the group is a guard: a shell that reads a pipe which only we hold open. The kernel closes
/// the pipe when our process ends, also after SIGKILL; then the guard kills the group.
/// PR_SET_PDEATHSIG would not do: it spares the child's children, and fires when the starting thread ends.
class ProcessGroup {
 public:
  /// Starts the guard. Throws Error when that cannot be done.
  ProcessGroup();
  ~ProcessGroup() { kill(); }
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;

  /// The group's number, for posix_spawnattr_setpgroup().
  pid_t id() const { return guard_; }
  /// The guard kills this child as well, even if it has left the group.
  void include(pid_t child);
  /// Sends SIGKILL to all processes of the group. Children must still be waited for.
  void kill();

 private:
  pid_t guard_ = -1;
  // Our end of the pipe.
  int lifeline_ = -1;
};

/// Runs the program without a shell, in a process group of its own, with no other open file of ours. It is
/// ended with the whole group when this object goes, or when our process ends in any way. Invariant: at most
/// one question is unanswered. Life cycle: the constructor starts the program; once it has hung or ended,
/// nothing more can be asked.
class LineProcess {
 public:
  struct Settings {
    /// Program and arguments. A program without a slash is one in `folder`, else one in $PATH.
    std::vector<std::string> command;
    /// Its working folder.
    std::filesystem::path folder;
    /// Limit of one answer [bytes].
    std::size_t maxLine = std::size_t{16} << 20U;
  };

  /// Starts it. Throws Error when that cannot be done.
  explicit LineProcess(const Settings& settings);
  ~LineProcess();
  LineProcess(const LineProcess&) = delete;
  LineProcess& operator=(const LineProcess&) = delete;

  enum class Outcome {
    answered,
    /// No line in time; it has been killed.
    hung,
    /// It is gone or has closed its output.
    ended,
  };

  /// Writes `question` and waits at most `timeout` for the line that answers it, whatever else the program
  /// does. Throws Error when it wrote without being asked or the line is too long.
  Outcome ask(std::string_view question, std::chrono::milliseconds timeout, std::string& answer);

  /// How it came to its end: "exit status 3", "signal 11 (Segmentation fault)".
  const std::string& end() const { return end_; }
  /// The last lines that it wrote to stderr, for a message; "" when there were none.
  std::string lastWords() const;

 private:
  bool takeLine(std::string& line);
  void readComplaints();
  void write(std::string_view& rest);
  void finish(std::chrono::milliseconds patience);

  ProcessGroup group_;
  pid_t pid_ = -1;
  int input_ = -1, output_ = -1, complaints_ = -1;  // our ends of its stdin, stdout and stderr
  std::size_t maxLine_;
  std::string pending_;       // output that was read but not returned yet
  std::size_t searched_ = 0;  // bytes of pending_ that contain no line end
  std::string complaintsTail_, end_;
};

}  // namespace estancia
