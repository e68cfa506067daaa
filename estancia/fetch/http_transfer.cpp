#include "estancia/fetch/http_transfer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "estancia/core/error.hpp"
#include "estancia/fetch/curl_request.hpp"

namespace estancia {
namespace {

using End = TransferResult::End;

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
    set(CURLOPT_FOLLOWLOCATION, 1L);
    set(CURLOPT_MAXREDIRS, 8L);
    set(CURLOPT_REDIR_PROTOCOLS_STR, url.starts_with("https:") ? "https" : "http,https");
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

  bool refuse(const std::string& reason) {
    refusal_ = reason;
    return false;
  }

  bool onBody(std::string_view bytes) override {
    if (!begun_ && !begin()) return false;
    if (part_.size() + bytes.size() > maxBytes_)
      return refuse(fmt::format("sent more than the {} bytes allowed", maxBytes_));
    const std::uint64_t before = part_.size() / 1000;
    part_.append(bytes);
    progress_.advance(part_.size() / 1000 - before);
    return true;
  }

  TransferResult ended(CURLcode code) const {
    if (!refusal_.empty()) return {End::refused, refusal_};
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
      case CURLE_OPERATION_TIMEDOUT:
        return {connected() ? End::broken : End::refused,
                connected() ? "stopped sending" : "does not answer"};
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

  bool connected() const { return info<double>(CURLINFO_CONNECT_TIME) > 0; }

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
  std::uint64_t total_ = 0;  // bytes of the whole file; 0 = the server does not say
  std::string refusal_;      // why the answer is not wanted
};

}  // namespace

TransferResult transfer(const std::string& url, bool resume, const RemoteFile& file, PartialFile& part,
                        Progress& progress, const DownloadOptions& options) {
  return Transfer(url, resume, file, part, progress, options).run();
}

}  // namespace estancia
