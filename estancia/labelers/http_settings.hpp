// HTTP labeler settings: the part of model.toml about a web service.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estancia/labelers/black_box.hpp"
#include "estancia/labelers/model_spec.hpp"

namespace estancia {

/// Where and how to ask.
struct HttpEndpoint {
  /// "https://host:port".
  std::string server;
  /// "/v2/label?lang=en", sent as it is.
  std::string path;
  std::string contentType;
  std::vector<std::pair<std::string, std::string>> headers;
  /// PEM file of trusted certificates; "" = those of the system.
  std::filesystem::path certificates;
  std::chrono::milliseconds connectTimeout{10'000};
  /// Limit of silence, to about a second.
  std::chrono::milliseconds readTimeout{30'000};
  /// Limit of the whole request, however slowly its bytes arrive.
  std::chrono::milliseconds timeout{60'000};
  /// [bytes].
  std::size_t maxAnswer = std::size_t{4} << 20U;
};

struct HttpSettings {
  /// URL as written, without the secrets: for messages.
  std::string url;
  HttpEndpoint endpoint;
  /// Values from the environment, never to be shown.
  std::vector<std::string> secrets;

  /// Form field for the image; "" sends the image as the whole body.
  std::string field;
  /// JSON in which ${image} stands for the image in base64; "" = no JSON.
  std::string bodyTemplate;
  /// Or "png".
  std::string format = "jpg";
  /// JPEG quality.
  int quality = 95;

  /// In all.
  int attempts = 5;
  /// Before the second attempt; doubled for each further one.
  std::chrono::milliseconds backoff{500};
  /// Between two attempts.
  std::chrono::milliseconds maxWait{60'000};
  /// Requests a second at most; 0 = any.
  double rate = 0;
  /// Requests in flight.
  std::size_t parallel = 4;
  /// Seed of the jitter of waiting times.
  std::uint64_t seed = 1;
  AnswerSettings answer;
  std::string identity;
};

/// Throws Error `…/model.toml:LINE: …`, also when a secret's variable is not set.
HttpSettings readHttpSettings(const ModelSpec& spec);

/// The body of the request for a BGR image. Throws cv::Exception when the image cannot be packed.
std::string requestBody(const HttpSettings& settings, const cv::Mat& bgr);

/// `text` with *** in the place of every secret.
std::string withoutSecrets(std::string text, const std::vector<std::string>& secrets);

}  // namespace estancia
