// SPDX-License-Identifier: Apache-2.0
#include "skipped.hpp"

#include <spdlog/spdlog.h>

namespace estancia::apps {

void Skipped::add(std::string_view problem) {
  if (++count_ <= maxReported) spdlog::warn("{}: {}", verb_, problem);
}

Skipped::~Skipped() {
  if (count_ > maxReported) spdlog::warn("{}: {} more, {} in all", verb_, count_ - maxReported, count_);
}

}  // namespace estancia::apps
