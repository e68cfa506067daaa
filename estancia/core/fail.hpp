// fail(): throws Error with a formatted message.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/core.h>

#include "estancia/core/error.hpp"

namespace estancia {

[[noreturn]] void failFormatted(ErrorCode code, fmt::string_view format, fmt::format_args args);

template <class... Args>
[[noreturn]] void fail(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  failFormatted(code, format, fmt::make_format_args(args...));
}

}  // namespace estancia
