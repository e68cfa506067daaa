// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/http_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "estancia/core/ascii.hpp"
#include "estancia/core/base64.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/image_codecs.hpp"
#include "estancia/core/png.hpp"
#include "estancia/files/files.hpp"
#include "estancia/labelers/model_files.hpp"

namespace estancia {
namespace {

using std::chrono::milliseconds;

constexpr std::string_view placeholder = "${image}";
constexpr std::string_view boundary = "estancia-f0e1c6b27d9a4835";  // occurs in no image

bool hasControls(std::string_view text) {
  return std::ranges::any_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7F; });
}

/// Reads the settings, and replaces ${NAME} by environment variables.
class Reader {
 public:
  explicit Reader(const ModelSpec& spec) : spec_(spec), config_(spec.folder / "model.toml") {}

  HttpSettings read() {
    auto keys = settings_.answer.keys(config_);
    const auto time = [this](milliseconds& value) {
      return [this, &value](const toml::node& n) {
        value = milliseconds(std::llround(1000 * config_.number(n, 0.001, 86'400)));
      };
    };
    auto& endpoint = settings_.endpoint;
    for (ConfigFile::Key& key : std::vector<ConfigFile::Key>{
             {"url", true, "where the service is", [this](auto& n) { readUrl(n); }},
             {"headers", false, "headers to send", [this](auto& n) { readHeaders(n); }},
             {"field", false, "the form's field for the image", [this](auto& n) { readField(n); }},
             {"body", false, "JSON around the image", [this](auto& n) { readBody(n); }},
             {"format", false, "\"jpg\" or \"png\"",
              [this](auto& n) {
                settings_.format = config_.choice<std::string>(n, {{"jpg", "jpg"}, {"png", "png"}});
              }},
             {"quality", false, "JPEG's quality",
              [this](auto& n) { settings_.quality = static_cast<int>(config_.integer(n, 1, 100)); }},
             {"ca", false, "the certificates to trust",
              [this](auto& n) { settings_.endpoint.certificates = modelFile(spec_, config_.inside(n)); }},
             {"connect_timeout", false, "seconds to connect", time(endpoint.connectTimeout)},
             {"read_timeout", false, "seconds of silence", time(endpoint.readTimeout)},
             {"timeout", false, "seconds a request may take", time(endpoint.timeout)},
             {"attempts", false, "how often to try",
              [this](auto& n) { settings_.attempts = static_cast<int>(config_.integer(n, 1, 100)); }},
             {"backoff", false, "seconds before trying again", time(settings_.backoff)},
             {"max_wait", false, "seconds to wait at most", time(settings_.maxWait)},
             {"rate", false, "requests a second",
              [this](auto& n) { settings_.rate = config_.number(n, 1e-4, 1e6); }},
             {"parallel", false, "requests in flight",
              [this](auto& n) { settings_.parallel = static_cast<std::size_t>(config_.integer(n, 1, 64)); }},
             {"seed", false, "of the waits", [this](auto& n) {
                settings_.seed = static_cast<std::uint64_t>(config_.integer(n, 0, INT64_MAX));
              }}})
      keys.push_back(std::move(key));
    readBlackBox(config_, std::move(keys));
    if (!settings_.field.empty() && !settings_.bodyTemplate.empty())
      fail(ErrorCode::malformedFile, "{}: `field` and `body` exclude each other; the image is sent once",
           config_.path().string());
    settings_.identity = blackBoxIdentity(spec_, config_, {},
                                          {"ca", "connect_timeout", "read_timeout", "timeout", "attempts",
                                           "backoff", "max_wait", "rate", "parallel", "seed"});
    endpoint.contentType = !settings_.field.empty()
                               ? fmt::format("multipart/form-data; boundary={}", boundary)
                           : !settings_.bodyTemplate.empty() ? "application/json"
                           : settings_.format == "jpg"       ? "image/jpeg"
                                                             : "image/png";
    return std::move(settings_);
  }

 private:
  void readUrl(const toml::node& node) {
    settings_.url = config_.text(node);
    const std::string url = withEnvironment(node, settings_.url);
    const auto begin = url.starts_with("https://") ? 8U : url.starts_with("http://") ? 7U : 0U;
    const auto end = std::min(url.find_first_of("/?#", begin), url.size());
    if (begin == 0 || end == begin || url.find_first_of(" @#") != std::string::npos)
      config_.fail(node,
                   "`url` must be http://HOST/… or https://HOST/…; users and keys belong into `headers`");
    settings_.endpoint.server = url.substr(0, end);
    settings_.endpoint.path = url.substr(end);
    if (!settings_.endpoint.path.starts_with('/')) settings_.endpoint.path.insert(0, "/");
  }

  void readHeaders(const toml::node& node) {
    for (const auto& [name, value] : config_.subtable(node)) {
      const std::string key(name.str());
      const auto isToken = [](char c) { return isLetterOrDigit(c) || c == '-' || c == '_'; };
      if (key.empty() || !std::ranges::all_of(key, isToken))
        config_.fail(value, "a header's name is made of letters, digits, - and _");
      settings_.endpoint.headers.emplace_back(key, withEnvironment(value, config_.text(value)));
    }
  }

  void readField(const toml::node& node) {
    settings_.field = config_.text(node);
    if (settings_.field.empty() || hasControls(settings_.field) ||
        settings_.field.find('"') != std::string::npos)
      config_.fail(node, "`field` must be a name without quotes");
  }

  void readBody(const toml::node& node) {
    settings_.bodyTemplate = config_.text(node);
    if (settings_.bodyTemplate.find(placeholder) == std::string::npos)
      config_.fail(node, fmt::format("`body` must hold {}, where the image in base64 goes", placeholder));
  }

  std::string withEnvironment(const toml::node& node, std::string text) {
    for (std::size_t begin = 0; (begin = text.find("${", begin)) != std::string::npos;) {
      const auto end = text.find('}', begin);
      if (end == std::string::npos) config_.fail(node, "a ${ without its }");
      const std::string name = text.substr(begin + 2, end - begin - 2);
      const char* value = std::getenv(name.c_str());
      if (value == nullptr || *value == '\0')
        config_.fail(node, fmt::format("`{}` needs the environment variable {}, which is not set",
                                       config_.key(), io::printable(name)));
      settings_.secrets.emplace_back(value);
      text.replace(begin, end + 1 - begin, value);
      begin += settings_.secrets.back().size();
    }
    if (hasControls(text))
      config_.fail(node, fmt::format("`{}` holds a line end or another control character", config_.key()));
    return text;
  }

  const ModelSpec& spec_;
  ConfigFile config_;
  HttpSettings settings_;
};

}  // namespace

HttpSettings readHttpSettings(const ModelSpec& spec) {
  return Reader(spec).read();
}

std::string requestBody(const HttpSettings& settings, const cv::Mat& bgr) {
  const std::vector<unsigned char> image =
      settings.format == "jpg" ? imageCodecs().encodeJpeg(bgr, settings.quality) : toPng(bgr);
  const std::string bytes(image.begin(), image.end());
  if (!settings.bodyTemplate.empty()) {
    std::string body = settings.bodyTemplate;
    const std::string text = toBase64(bytes);
    for (std::size_t at = 0; (at = body.find(placeholder, at)) != std::string::npos; at += text.size())
      body.replace(at, placeholder.size(), text);
    return body;
  }
  if (settings.field.empty()) return bytes;
  return fmt::format(
      "--{0}\r\nContent-Disposition: form-data; name=\"{1}\"; filename=\"image.{2}\"\r\nContent-Type: "
      "image/{3}\r\n\r\n{4}\r\n--{0}--\r\n",
      boundary, settings.field, settings.format, settings.format == "jpg" ? "jpeg" : "png", bytes);
}

std::string withoutSecrets(std::string text, const std::vector<std::string>& secrets) {
  constexpr std::string_view instead = "***";
  for (const std::string& secret : secrets)
    for (std::size_t at = 0; (at = text.find(secret, at)) != std::string::npos; at += instead.size())
      text.replace(at, secret.size(), instead);
  return text;
}

}  // namespace estancia
