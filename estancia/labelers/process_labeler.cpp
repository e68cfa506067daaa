// Process labeler: a program of the user that labels images.
// SPDX-License-Identifier: Apache-2.0
#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "estancia/core/ascii.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/png.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/label_scores.hpp"
#include "estancia/labelers/black_box.hpp"
#include "estancia/labelers/line_process.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view prefix = "estancia-", unique = "XXXXXX";
constexpr const char* lockName = "estancia.lock";

/// Whether mkdtemp() made this name from our pattern.
bool isOurs(const std::string& name) {
  return name.starts_with(prefix) && name.size() == prefix.size() + unique.size() &&
         std::all_of(name.begin() + prefix.size(), name.end(), isLetterOrDigit);
}

/// Whether the open file is this user's and of this type (S_IFDIR, S_IFREG).
bool isOwn(int file, mode_t type) {
  struct stat status {};
  return fstat(file, &status) == 0 && status.st_uid == geteuid() && (status.st_mode & S_IFMT) == type;
}

/// Removes the folder if it has a lock that no process holds. Follows no links, enters no folder in it.
void removeIfAbandoned(const fs::path& folder) {
  const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (opened < 0) return;
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(fdopendir(opened), closedir);
  if (!entries) ::close(opened);
  if (!entries || !isOwn(opened, S_IFDIR)) return;
  const int lock = openat(opened, lockName, O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (lock < 0) return;
  if (isOwn(lock, S_IFREG) && flock(lock, LOCK_EX | LOCK_NB) == 0) {
    bool empty = true;
    while (const dirent* entry = readdir(entries.get())) {
      const std::string_view name = entry->d_name;
      if (name != "." && name != ".." && name != lockName)
        empty = unlinkat(opened, entry->d_name, 0) == 0 && empty;
    }
    if (empty && unlinkat(opened, lockName, 0) == 0) rmdir(folder.c_str());
  }
  ::close(lock);
}

void removeAbandonedIn(const fs::path& temporary) {
  std::error_code problem;
  for (fs::directory_iterator entry(temporary, problem), end; !problem && entry != end;
       entry.increment(problem))
    if (isOurs(entry->path().filename().string())) removeIfAbandoned(entry->path());
}

/// A folder `estancia-XXXXXX` in the temporary folder ($TMPDIR, else /tmp). Its owner holds a lock on a file
/// in it (flock(2)), which the kernel releases however the owner ends.
class PrivateFolder {
 public:
  /// Removes those that killed processes of this user have left, then makes one. Throws Error.
  PrivateFolder() {
    const fs::path temporary = fs::temp_directory_path();
    removeAbandonedIn(temporary);
    for (;;) {
      std::string pattern = (temporary / prefix).string().append(unique);
      const bool made = mkdtemp(pattern.data()) != nullptr;
      if (made)
        lock_ = ::open((fs::path(pattern) / lockName).c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
      if (lock_ < 0) {
        const int why = errno;
        if (made) rmdir(pattern.c_str());
        fail(ErrorCode::fileUnwritable,
             "cannot make a folder for images ({}): {}; set TMPDIR to one that can be written",
             printable(pattern), std::strerror(why));
      }
      path_ = pattern;
      if (flock(lock_, LOCK_EX) != 0) {  // a file system without locks: never to be taken for abandoned
        unlink((path_ / lockName).c_str());
        return;
      }
      struct stat status {};
      if (fstat(lock_, &status) == 0 && status.st_nlink > 0) return;
      ::close(lock_);  // another process has taken it for abandoned before it was locked
      lock_ = -1;
    }
  }

  ~PrivateFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    ::close(lock_);
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  int lock_ = -1;
};

using std::chrono::milliseconds;

struct Settings {
  LineProcess::Settings process;
  milliseconds timeout{30'000};        ///< an image
  milliseconds startTimeout{120'000};  ///< the first one: it may have to load a network
  AnswerSettings answer;
  std::string identity;
};

Settings readSettings(const ModelSpec& spec) {
  ConfigFile config(spec.folder / "model.toml");
  Settings settings;
  settings.process.folder = spec.folder;
  const auto seconds = [&](auto& n) {
    return milliseconds(std::llround(1000 * config.number(n, 0.001, 86'400)));
  };
  auto keys = settings.answer.keys(config);
  keys.push_back({"command", true, "the program and its arguments", [&](auto& n) {
                    for (const auto& word : config.list(n))
                      settings.process.command.push_back(config.text(word));
                    if (settings.process.command.empty() || settings.process.command[0].empty())
                      config.fail(n, "`command` must name a program: [\"python3\", \"my_labeler.py\"]");
                  }});
  keys.push_back(
      {"timeout", false, "how long an image may take", [&](auto& n) { settings.timeout = seconds(n); }});
  keys.push_back({"start_timeout", false, "how long the first image may take",
                  [&](auto& n) { settings.startTimeout = seconds(n); }});
  readBlackBox(config, std::move(keys));
  const auto& command = settings.process.command;  // another script is another model
  settings.identity =
      blackBoxIdentity(spec, config, {command.begin(), command.end()}, {"timeout", "start_timeout"});
  return settings;
}

/// A file as long as the program may look at it.
class PassingFile {
 public:
  PassingFile(fs::path path, const cv::Mat& bytes) : path_(std::move(path)) {
    std::ofstream file(path_, std::ios::binary);
    file.write(bytes.ptr<char>(), static_cast<std::streamsize>(bytes.total()));
    file.close();
    if (!file) fail(ErrorCode::fileUnwritable, "{}: cannot be written; is the disk full?", path_.string());
  }
  ~PassingFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  PassingFile(const PassingFile&) = delete;
  PassingFile& operator=(const PassingFile&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Labels images by a program that answers a line an image. Life cycle: the program starts with the first
/// image and is started again once for an image at which it ended or hung. Invariant: `process_` is empty
/// whenever its answers could be out of step with the questions.
class ProcessLabeler final : public Labeler {
 public:
  explicit ProcessLabeler(const ModelSpec& spec)
      : source_("model " + spec.name), settings_(readSettings(spec)), book_(wordBook(spec)) {}

  const Vocabulary& vocabulary() const override { return book_.vocabulary(); }
  bool discovers() const override { return book_.discovers(); }
  LexicalDescriptor adopt(std::span<const LabelProbability> words) override {
    return describe(book_, {words.begin(), words.end()}, 0, source_);
  }
  std::string identity() const override { return settings_.identity; }

  /// The image as PNG: whole, and quickly packed.
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override {
    try {
      return {cv::Mat(toPng(bgr), true).reshape(1, 1), frame, {}};
    } catch (const Error& e) {
      fail(e.code(), "{}: the image {} cannot be handed on: {}", source_, frame, e.what());
    }
  }

  LexicalDescriptor infer(const Prepared& prepared) override {
    const PassingFile image(folder_.path() / fmt::format("{:06}.png", number_++), prepared.input);
    const io::Answer answer = ask(image.path());
    if (!answer.error.empty()) throw FrameError(fmt::format("{}: {}", source_, answer.error));
    return describe(book_, answer.words, settings_.answer.best, source_);
  }

 private:
  io::Answer ask(const fs::path& image) {
    using Outcome = LineProcess::Outcome;
    for (bool again = false;; again = true) try {
        if (!process_) {
          process_.emplace(settings_.process);
          hasAnswered_ = false;
        }
        std::string line;
        const auto timeout = hasAnswered_ ? settings_.timeout : settings_.startTimeout;
        const Outcome outcome = process_->ask(image.string(), timeout, line);
        if (outcome == Outcome::answered) {
          io::Answer answer = io::readAnswer(line, settings_.answer.format, source_);
          requireAnswerTo(image, answer.image);
          hasAnswered_ = true;
          return answer;
        }
        const std::string what =
            outcome == Outcome::hung
                ? fmt::format(
                      "gave no answer within {} s and was killed (does it flush stdout after each line?)",
                      std::chrono::duration<double>(timeout).count())
                : fmt::format("ended without an answer ({})", process_->end());
        std::string words = process_->lastWords();
        words = words.empty() ? "it wrote nothing to stderr" : "its last words: " + words;
        // A program that has not answered at all will not do so the second time either, and waiting is long.
        const bool hopeless = outcome == Outcome::hung && !hasAnswered_;
        process_.reset();
        if (again || hopeless)
          fail(ErrorCode::labelerFailure, "{}: the program {}{}; {}", source_, what,
               again ? ", twice in a row" : "", words);
      } catch (const Interrupted&) {
        process_.reset();
        throw;
      } catch (const Error& e) {
        process_.reset();
        const std::string message = e.what();
        if (message.starts_with(source_)) throw;
        throw Error(e.code(), fmt::format("{}: the program {}", source_, message));
      }
  }

  void requireAnswerTo(const fs::path& image, const std::string& answered) const {
    if (answered == image.string() || answered == image.filename().string()) return;
    if (answered.empty())
      fail(ErrorCode::labelerFailure, "{}: its answer does not say for which \"image\" it is", source_);
    fail(ErrorCode::labelerFailure,
         "{}: it answered for \"{}\" when asked for {}; one line for each, in order", source_,
         io::printable(answered.substr(0, 200)), image.string());
  }

  std::string source_;
  Settings settings_;
  io::WordBook book_;
  PrivateFolder folder_;
  std::size_t number_ = 0;
  std::optional<LineProcess> process_;
  bool hasAnswered_ = false;  // this process, since it started
};

}  // namespace

std::unique_ptr<Labeler> openProcess(const ModelSpec& spec) {
  return std::make_unique<ProcessLabeler>(spec);
}

}  // namespace estancia
