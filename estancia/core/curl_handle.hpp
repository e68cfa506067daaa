// One transfer of libcurl. Used by the .cpp files that speak HTTP.
#pragma once

#include <curl/curl.h>

#include <memory>

namespace estancia {

using CurlHandle = std::unique_ptr<CURL, decltype(&curl_easy_cleanup)>;

/// Starts libcurl when it is the first. Throws Error when that fails.
CurlHandle makeCurlHandle();

}  // namespace estancia
