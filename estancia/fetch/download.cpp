#include "estancia/fetch/download.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <system_error>
#include <thread>

#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/options.hpp"
#include "estancia/fetch/http_transfer.hpp"
#include "estancia/fetch/partial_file.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr int maxTries = 30;          // of one address, however small its pieces
constexpr int maxFruitlessTries = 3;  // in a row that brought no byte

std::string hostOf(const std::string& url) {
  const auto begin = url.find("://") == std::string::npos ? 0 : url.find("://") + 3;
  return url.substr(begin, url.find('/', begin) - begin);
}

void pause(int seconds) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::seconds(seconds);
  while (Clock::now() < until && !interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

class Download {
 public:
  Download(const RemoteFile& file, PartialFile& part, Progress& progress, const DownloadOptions& options)
      : file_(file), part_(part), progress_(progress), options_(options) {}

  /// Fetches from one address until all is there and right. Returns why not, "" when it is.
  std::string from(const std::string& url) {
    int fruitless = 0;
    std::string reason;
    for (int tries = 0; tries < maxTries && fruitless < maxFruitlessTries; ++tries) {
      if (tries > 0 && fruitless > 0) pause(std::max(fruitless * options_.pauseSeconds, wait_));
      const std::uint64_t before = part_.size();
      const auto result = next(url);
      wait_ = result.retryAfter;
      reason = result.reason;
      switch (result.end) {
        case TransferResult::End::complete:
          reason = differenceFrom(file_, part_.path());
          if (reason.empty()) return "";
          discard();
          if (!result.resumed) return reason;
          ++fruitless;  // two halves of different files: all of it anew
          break;
        case TransferResult::End::misfit:
          if (before == 0) return reason;
          discard();
          ++fruitless;
          break;
        case TransferResult::End::broken:
          fruitless = part_.size() > before ? 0 : fruitless + 1;
          break;
        case TransferResult::End::refused:
          return reason;
      }
    }
    return reason;
  }

 private:
  TransferResult next(const std::string& url) {
    if (file_.size > 0 && part_.size() == file_.size) return {TransferResult::End::complete, "", true};
    // Bytes of another address, or of a server that names no version, are trusted only if a digest will tell.
    const bool digest = !file_.sha256.empty() || !file_.sha1.empty();
    const bool same = part_.source() == url && !part_.version().empty();
    return transfer(url, digest || same, file_, part_, progress_, options_);
  }

  void discard() { part_.restart("", ""); }

  const RemoteFile& file_;
  PartialFile& part_;
  Progress& progress_;
  const DownloadOptions& options_;
  int wait_ = 0;
};

}  // namespace

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::string differenceFrom(const RemoteFile& file, const fs::path& path) {
  const auto differ = [](const char* what, const auto& actual, const auto& expected) {
    return fmt::format("has {} {} where {} is expected", what, actual, expected);
  };
  if (const auto size = fs::file_size(path); file.size > 0 && size != file.size)
    return differ("the size", size, file.size);
  if (!file.sha256.empty())
    if (const auto actual = sha256OfFile(path); actual != file.sha256)
      return differ("SHA-256", actual, file.sha256);
  if (!file.sha1.empty())
    if (const auto actual = sha1OfFile(path); actual != file.sha1) return differ("SHA-1", actual, file.sha1);
  return "";
}

OptionGroup declare(DownloadOptions& options) {
  OptionGroup group("download", "How files are fetched.");
  group.add("max-bytes", &options.maxBytes, "The largest file that is fetched.").range(1).unit("bytes");
  group.add("connect-seconds", &options.connectSeconds, "Time until a connection stands.")
      .range(1, 3600)
      .unit("s");
  group.add("stall-seconds", &options.stallSeconds, "Time below 1 kB/s after which a server counts as dead.")
      .range(1, 86'400)
      .unit("s");
  group.add("pause-seconds", &options.pauseSeconds, "Pause before a second try.").range(0, 3600).unit("s");
  return group;
}

void download(const RemoteFile& file, const fs::path& target, const DownloadOptions& options,
              Progress& progress) {
  validate(options);
  std::vector<std::string> reasons;
  if (fs::is_regular_file(target)) {
    const std::string difference = differenceFrom(file, target);
    if (difference.empty()) return;
    reasons.push_back(fmt::format("the present file {}", difference));
  }
  PartialFile part(target);
  for (const std::string& url : file.urls) {
    const std::string reason = Download(file, part, progress, options).from(url);
    if (reason.empty()) return part.finish();
    reasons.push_back(fmt::format("{} {}", hostOf(url), reason));
  }
  fail(ErrorCode::network,
       "cannot fetch {}: {}{}; run this again later, or fetch {} by hand and put it at {}",
       target.filename().string(), fmt::join(reasons, "; "),
       part.size() > 0 ? fmt::format(" ({} are kept)", megabytes(part.size())) : "",
       file.urls.empty() ? "it" : file.urls.front(), target.string());
}

}  // namespace estancia
