// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/fail.hpp"

namespace estancia {

void failFormatted(ErrorCode code, fmt::string_view format, fmt::format_args args) {
  throw Error(code, fmt::vformat(format, args));
}

}  // namespace estancia
