// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/frame_failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <opencv2/core.hpp>
#include <string_view>

namespace estancia {
namespace {

/// Other libraries break lines, and quote bytes of damaged files.
Error unexpected(const std::string& frame, std::string_view reason) {
  std::string line(reason.substr(0, 200));
  std::ranges::replace_if(
      line, [](char c) { return c < ' ' || c > '~'; }, ' ');
  return Error(
      ErrorCode::invalidInput,
      fmt::format("{}: fails unexpectedly ({}); replace or remove its file, and report it if it is sound",
                  frame, line));
}

}  // namespace

Error frameFailure(const std::string& frame) {
  try {
    throw;
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& e) {
    if (e.code() == ErrorCode::missingDependency) throw;
    return {e.code(), e.what()};
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const cv::Exception& e) {
    if (e.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return unexpected(frame, e.err);
  } catch (const std::exception& e) {
    return unexpected(frame, e.what());
  }
}

}  // namespace estancia
