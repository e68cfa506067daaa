// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <mutex>

#include "estancia/core/take_interrupt.hpp"
#include "estancia/core/time_left.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;

volatile std::sig_atomic_t stopRequested = 0;
/// Set once interrupted() has reported the interrupt.
volatile std::sig_atomic_t stopHeard = 0;
constexpr unsigned secondsToHear = 5;  // more than the label of one image takes

void endUnheard(int) {
  if (stopHeard != 0) return;
  const int asked = stopRequested;
  std::signal(asked, SIG_DFL);
  std::raise(asked);
}

void requestStop(int signal) {
  stopRequested = signal;
  // A closed terminal sends it twice (the shell, then the kernel): the second one must not kill.
  if (signal != SIGHUP) std::signal(signal, SIG_DFL);
  alarm(secondsToHear);
}

std::string clockText(double seconds) {
  const long s = std::lround(seconds);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// Columns of the terminal; it may be resized at any time.
std::size_t terminalWidth() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

/// Whether a line of progress stands on the terminal, where the next output would go on in it.
std::mutex lineMutex;
bool isLineShown = false;

/// Progress on stderr: a bar redrawn in place on a terminal, else a line each five seconds. Life cycle:
/// begin(), advance() any number of times, end(), again and again. Invariant: outside begin() … end() no
/// unfinished bar is on the terminal.
class StderrProgress final : public Progress {
 public:
  ~StderrProgress() override { end(); }

  void begin(const std::string& what, std::size_t total, std::size_t done) override {
    end();
    what_ = what;
    left_ = TimeLeft(total, done);
    start_ = lastShown_ = Clock::now();
    active_ = true;
    isShownWhole_ = false;
    if (terminal_) show();
  }

  void advance(std::size_t count) override {
    if (!active_) return;  // work too short for a name
    left_.advance(count, seconds());
    const auto pause = terminal_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(5000);
    if (Clock::now() - lastShown_ >= pause) show();
  }

  void end() override {
    if (!active_) return;
    if (!isShownWhole_) show();
    active_ = false;
    if (!terminal_) return;
    const std::lock_guard lock(lineMutex);
    std::fputc('\n', stderr);
    isLineShown = false;
  }

 private:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  void show() {
    lastShown_ = Clock::now();
    const double now = seconds();
    const std::size_t total = left_.total(), done = left_.done();
    const double share =
        total > 0 ? static_cast<double>(std::min(done, total)) / static_cast<double>(total) : 0;
    std::string line =
        total > 0 ? fmt::format(" {:3.0f} % {}/{}", share * 100, done, total) : fmt::format(" {}", done);
    if (const auto rate = left_.rate(now)) line += fmt::format(", {:.1f}/s", *rate);
    if (left_.isComplete())
      line += fmt::format(", took {}", clockText(now));
    else if (const auto left = left_.seconds(now))
      line += fmt::format(", {} left", clockText(*left));
    const std::lock_guard lock(lineMutex);
    if (terminal_)
      std::fprintf(stderr, "\r\033[K%s", fitted(line, share).c_str());
    else
      std::fprintf(stderr, "%s%s\n", what_.c_str(), line.c_str());
    std::fflush(stderr);
    isLineShown = terminal_;
    isShownWhole_ = left_.isComplete() && !terminal_;
  }

  /// Name, bar and numbers on one line: a wrapped line could not be drawn over again.
  std::string fitted(const std::string& numbers, double share) const {
    constexpr std::size_t longest = 28, shortest = 5;
    const std::size_t width = terminalWidth() - 1, text = what_.size() + numbers.size();
    if (text > width) return (what_ + numbers).substr(0, width);
    const std::size_t bar = std::min(longest, width - text);
    std::string line = what_;
    if (left_.total() > 0 && bar > shortest) {
      line += " ";
      for (std::size_t i = 0; i + 1 < bar; ++i)
        line += static_cast<double>(i) < std::floor(share * static_cast<double>(bar - 1)) ? "█" : "░";
    }
    return line + numbers;
  }

  bool terminal_ = isatty(STDERR_FILENO) == 1;
  bool active_ = false;
  bool isShownWhole_ = false;  // a line of a file, which stays
  std::string what_;
  TimeLeft left_;
  Clock::time_point start_, lastShown_;
};

}  // namespace

Progress& Progress::none() {
  static Progress silent;
  return silent;
}

std::unique_ptr<Progress> makeStderrProgress() {
  return std::make_unique<StderrProgress>();
}

void clearProgressLine() {
  const std::lock_guard lock(lineMutex);
  if (isLineShown) std::fputs("\r\033[K", stderr);
  isLineShown = false;
}

void catchInterrupts() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) std::signal(signal, requestStop);  // nohup, `trap '' INT`
  }
  std::signal(SIGALRM, endUnheard);
  std::signal(SIGXFSZ, SIG_IGN);  // writing beyond `ulimit -f` then fails as on a full disk
}

bool interrupted() {
  if (stopRequested == 0) return false;
  stopHeard = 1;
  return true;
}

void requestInterrupt() {
  stopRequested = 1;
}

bool takeInterrupt() {
  const bool asked = interrupted();
  stopRequested = 0;
  return asked;
}

}  // namespace estancia
