#include "estancia/core/curl_handle.hpp"

#include "estancia/core/error.hpp"

namespace estancia {

CurlHandle makeCurlHandle() {
  static const CURLcode once = curl_global_init(CURL_GLOBAL_DEFAULT);
  CurlHandle handle(once == CURLE_OK ? curl_easy_init() : nullptr, &curl_easy_cleanup);
  if (!handle) throw Error("libcurl cannot be started; is there memory left?");
  return handle;
}

}  // namespace estancia
