// What model.toml says about a web service.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estancia/label/black_box.hpp"
#include "estancia/label/http_connection.hpp"
#include "estancia/label/model_spec.hpp"

namespace estancia {

struct HttpSettings {
  std::string url;  ///< as written, without the secrets: for messages
  HttpEndpoint endpoint;
  std::vector<std::string> secrets;  ///< values from the environment, never to be shown

  std::string field;           ///< of a form to put the image in; "" sends it as the whole body
  std::string bodyTemplate;    ///< JSON in which ${image} stands for the image in base64; "" = no JSON
  std::string format = "jpg";  ///< or "png"
  int quality = 95;            ///< of JPEG

  int attempts = 5;                           ///< in all
  std::chrono::milliseconds backoff{500};     ///< before the second attempt; doubled for each further one
  std::chrono::milliseconds maxWait{60'000};  ///< between two attempts
  double rate = 0;                            ///< requests a second at most; 0 = any
  std::size_t parallel = 4;                   ///< requests in flight
  std::uint64_t seed = 1;                     ///< of the waits' jitter
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
