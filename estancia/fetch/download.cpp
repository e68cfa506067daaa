// SPDX-License-Identifier: Apache-2.0
#include "estancia/fetch/download.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/options.hpp"
#include "estancia/fetch/curl_request.hpp"
#include "estancia/fetch/partial_file.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// How a request ended.
struct TransferResult {
  enum class End {
    complete,  ///< the server has sent the whole file
    broken,    ///< it may be gone on with
    misfit,    ///< the server has no such rest: begin anew
    refused,   ///< no use in asking again
    tooLong,   ///< a retry is of no use, nor are the bytes received
  };
  End end = End::complete;
  std::string reason;    ///< why it is not complete, for people
  bool resumed = false;  ///< bytes were added to what was there before
  int retryAfter = 0;    ///< seconds that the server asks to wait
};

using End = TransferResult::End;

/// Asks for `url` and writes what comes to `part`; with `resume` for the rest of what `part` holds, which the
/// server may answer with all of it. Refuses what has not file.size bytes. Throws Interrupted, and as `part`.
class Transfer final : private CurlRequest {
 public:
  Transfer(const std::string& url, bool resume, const RemoteFile& file, PartialFile& part, Progress& progress,
           const DownloadOptions& options)
      : url_(url),
        resume_(resume && part.size() > 0),
        maxBytes_(file.size > 0 ? file.size : options.maxBytes),
        file_(file),
        part_(part),
        progress_(progress) {
    setUrl(url);
    set(CURLOPT_FAILONERROR, 1L);
    followRedirections(url.starts_with("https:"));
    set(CURLOPT_CONNECTTIMEOUT, static_cast<long>(options.connectSeconds));
    set(CURLOPT_LOW_SPEED_LIMIT, 1000L);
    set(CURLOPT_LOW_SPEED_TIME, static_cast<long>(options.stallSeconds));
    if (!resume_) return;
    set(CURLOPT_RANGE, fmt::format("{}-", part.size()).c_str());
    // Only of the same version: else the server sends all of it.
    if (part.source() == url && !part.version().empty()) addHeader("If-Range: " + part.version());
  }

  TransferResult run() {
    const CURLcode code = perform();
    progress_.end();
    if (interrupted())
      throw Interrupted(
          fmt::format("stopped with {}{} of {}; they are kept, and the same command goes on from there",
                      megabytes(part_.size()), total_ > 0 ? fmt::format(" of {}", megabytes(total_)) : "",
                      part_.path().stem().string()));
    if (code == CURLE_OK && !begun_) begin();  // an answer without a body
    TransferResult result = ended(code);
    result.resumed = begun_ && resume_ && status() == 206;
    return result;
  }

 private:
  /// Something that changes when the file does: a strong ETag (RFC 9110, 13.1.5), else the date.
  std::string version() const {
    const std::string tag = header("ETag");
    return tag.empty() || tag.starts_with("W/") ? header("Last-Modified") : tag;
  }

  /// Where a partial answer begins ("bytes 500-999/1000").
  std::uint64_t firstByte() const {
    const std::string range = header("Content-Range");
    constexpr std::string_view unit = "bytes ";
    std::uint64_t first = ~std::uint64_t{0};
    if (range.starts_with(unit))
      std::from_chars(range.data() + unit.size(), range.data() + range.size(), first);
    return first;
  }

  /// Looks at the head of the answer before its first byte is taken. False when it is not wanted.
  bool begin() {
    const bool rest = status() == 206 && resume_;
    if (!rest && status() != 200) return refuse(fmt::format("answered {}", status()));
    if (rest && firstByte() != part_.size()) return refuse("sent another part of the file than asked for");
    if (rest && version() != part_.version())
      return refuse("sent the rest of another version of the file; run this again");
    const auto announced = info<curl_off_t>(CURLINFO_CONTENT_LENGTH_DOWNLOAD_T);
    if (announced >= 0) {
      total_ = (rest ? part_.size() : 0) + static_cast<std::uint64_t>(announced);
      if (file_.size > 0 && total_ != file_.size)
        return refuse(fmt::format("offers {} bytes where {} are expected", total_, file_.size));
      if (total_ > maxBytes_)
        return refuse(fmt::format("offers {} bytes, more than the {} allowed", total_, maxBytes_));
    }
    if (!rest) part_.restart(url_, version());
    begun_ = true;
    progress_.begin(fmt::format("{} (kB)", part_.path().stem().string()), total_ / 1000, part_.size() / 1000);
    return true;
  }

  bool refuse(const std::string& reason, End end = End::refused) {
    refusal_ = {end, reason};
    return false;
  }

  bool onBody(std::string_view bytes) override {
    if (!begun_ && !begin()) return false;
    if (part_.size() + bytes.size() > maxBytes_)
      return refuse(fmt::format("sent more than the {} bytes allowed", maxBytes_), End::tooLong);
    const std::uint64_t before = part_.size() / 1000;
    part_.append(bytes);
    progress_.advance(part_.size() / 1000 - before);
    return true;
  }

  TransferResult ended(CURLcode code) const {
    if (refusal_) return *refusal_;
    const std::string why = curl_easy_strerror(code);
    switch (code) {
      case CURLE_OK:
        return {End::complete, ""};
      case CURLE_HTTP_RETURNED_ERROR:
        return answered();
      case CURLE_COULDNT_RESOLVE_HOST:
      case CURLE_COULDNT_RESOLVE_PROXY:
      case CURLE_COULDNT_CONNECT:
        return {End::refused, fmt::format("cannot be reached ({})", why)};
      case CURLE_OPERATION_TIMEDOUT:  // with or without a connection
        if (info<double>(CURLINFO_CONNECT_TIME) > 0) return {End::broken, "stopped sending"};
        return {End::refused, "does not answer"};
      case CURLE_PARTIAL_FILE:
      case CURLE_RECV_ERROR:
      case CURLE_SEND_ERROR:
      case CURLE_GOT_NOTHING:
      case CURLE_HTTP2:
      case CURLE_HTTP2_STREAM:
        return {End::broken, fmt::format("broke off after {}", megabytes(part_.size()))};
      case CURLE_PEER_FAILED_VERIFICATION:
        return {End::refused, "has no valid certificate: somebody may be listening in"};
      case CURLE_TOO_MANY_REDIRECTS:
        return {End::refused, "redirects too often, or in a circle"};
      case CURLE_UNSUPPORTED_PROTOCOL:
        return {End::refused, "redirects to an address that is not as safe (https) or not of the web"};
      default:
        return {End::refused, why};
    }
  }

  TransferResult answered() const {
    const long code = status();
    TransferResult result{End::refused, fmt::format("answered {}", code)};
    if (code == 416) result.end = End::misfit;
    if (code == 408 || code == 429 || code >= 500) result.end = End::broken;
    result.retryAfter =
        static_cast<int>(std::clamp<curl_off_t>(info<curl_off_t>(CURLINFO_RETRY_AFTER), 0, 30));
    return result;
  }

  std::string url_;
  bool resume_;
  std::uint64_t maxBytes_;
  const RemoteFile& file_;
  PartialFile& part_;
  Progress& progress_;
  bool begun_ = false;
  std::uint64_t total_ = 0;                // bytes of the whole file; 0 = not sent by the server
  std::optional<TransferResult> refusal_;  // why the answer is not wanted
};

constexpr int maxTries = 30;          // tries of one address, however small its pieces
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

/// Fetches from one address until all is there and right. Returns why not, "" when it is.
std::string fetchFrom(const std::string& url, const RemoteFile& file, PartialFile& part, Progress& progress,
                      const DownloadOptions& options) {
  const auto next = [&]() -> TransferResult {
    if (file.size > 0 && part.size() == file.size) return {End::complete, "", true};
    // Bytes of another address, or without a version, are trusted only if a digest will verify them.
    const bool same = part.source() == url && !part.version().empty();
    return Transfer(url, !file.sha256.empty() || same, file, part, progress, options).run();
  };
  int fruitless = 0, wait = 0;
  std::string reason;
  for (int tries = 0; tries < maxTries && fruitless < maxFruitlessTries; ++tries) {
    if (tries > 0 && fruitless > 0) pause(std::max(fruitless * options.pauseSeconds, wait));
    const std::uint64_t before = part.size();
    const TransferResult result = next();
    wait = result.retryAfter;
    reason = result.reason;
    switch (result.end) {
      case End::complete:
        reason = differenceFrom(file, part.path());
        if (reason.empty()) return "";
        part.restart("", "");
        if (!result.resumed) return reason;
        ++fruitless;  // two halves of different files: all of it anew
        break;
      case End::misfit:
        if (before == 0) return reason;
        part.restart("", "");
        ++fruitless;
        break;
      case End::broken:
        fruitless = part.size() > before ? 0 : fruitless + 1;
        break;
      case End::tooLong:
        part.restart("", "");
        return reason;
      case End::refused:
        return reason;
    }
  }
  return reason;
}

using Archive = std::unique_ptr<archive, decltype(&archive_read_free)>;

[[noreturn]] void failDamaged(const fs::path& path, archive* reader) {
  const char* reason = archive_error_string(reader);
  fail(ErrorCode::malformedFile, "{}: no archive, or damaged ({}); fetch it again", path.string(),
       reason == nullptr ? "unknown reason" : reason);
}

bool isCalled(archive_entry* entry, std::string_view name) {
  const char* path = archive_entry_pathname(entry);
  if (path == nullptr || archive_entry_filetype(entry) != AE_IFREG) return false;
  const std::string_view full(path);
  return full == name ||
         (full.size() > name.size() && full.ends_with(name) && full[full.size() - name.size() - 1] == '/');
}

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
    const std::string reason = fetchFrom(url, file, part, progress, options);
    if (reason.empty()) return part.finish();
    reasons.push_back(fmt::format("{} {}", hostOf(url), reason));
  }
  fail(ErrorCode::network,
       "cannot fetch {}: {}{}; run this again later, or fetch {} by hand and put it at {}",
       target.filename().string(), fmt::join(reasons, "; "),
       part.size() > 0 ? fmt::format(" ({} are kept)", megabytes(part.size())) : "",
       file.urls.empty() ? "it" : file.urls.front(), target.string());
}

bool extractMember(const fs::path& path, const std::string& name, const fs::path& target,
                   std::uint64_t maxBytes) {
  const Archive reader(archive_read_new(), &archive_read_free);
  // Not all that libarchive knows: some filters start programs.
  archive_read_support_filter_gzip(reader.get());
  archive_read_support_filter_bzip2(reader.get());
  archive_read_support_filter_xz(reader.get());
  archive_read_support_filter_zstd(reader.get());
  archive_read_support_format_tar(reader.get());
  archive_read_support_format_zip(reader.get());
  if (archive_read_open_filename(reader.get(), path.c_str(), 1 << 16) != ARCHIVE_OK)
    failDamaged(path, reader.get());
  archive_entry* entry = nullptr;
  int code = ARCHIVE_OK;
  while ((code = archive_read_next_header(reader.get(), &entry)) == ARCHIVE_OK || code == ARCHIVE_WARN) {
    if (!isCalled(entry, name)) continue;
    PartialFile part(target);
    part.restart(path.string(), "");
    std::array<char, 1 << 16> block{};
    la_ssize_t count = 0;
    while ((count = archive_read_data(reader.get(), block.data(), block.size())) > 0) {
      if (part.size() + static_cast<std::uint64_t>(count) > maxBytes) {
        part.restart("", "");
        fail(ErrorCode::tooLarge, "{}: {} in it is longer than the {} bytes allowed", path.string(), name,
             maxBytes);
      }
      part.append({block.data(), static_cast<std::size_t>(count)});
    }
    if (count < 0) {
      part.restart("", "");
      failDamaged(path, reader.get());
    }
    part.finish();
    return true;
  }
  if (code != ARCHIVE_EOF) failDamaged(path, reader.get());
  return false;
}

}  // namespace estancia
