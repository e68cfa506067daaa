// Version: the version of Estancia, for the preprocessor and for programs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#define ESTANCIA_VERSION_MAJOR 0
#define ESTANCIA_VERSION_MINOR 1
#define ESTANCIA_VERSION_PATCH 0

namespace estancia {

/// "0.1.0"
constexpr const char* version() {
#define ESTANCIA_TEXT_OF(x) #x
#define ESTANCIA_VERSION_TEXT(a, b, c) ESTANCIA_TEXT_OF(a) "." ESTANCIA_TEXT_OF(b) "." ESTANCIA_TEXT_OF(c)
  return ESTANCIA_VERSION_TEXT(ESTANCIA_VERSION_MAJOR, ESTANCIA_VERSION_MINOR, ESTANCIA_VERSION_PATCH);
#undef ESTANCIA_VERSION_TEXT
#undef ESTANCIA_TEXT_OF
}

}  // namespace estancia
