// A program of which Estancia is a part has chosen the user's language, as those with a graphical surface do;
// to be preloaded (LD_PRELOAD). SPDX-License-Identifier: Apache-2.0
#include <clocale>
#include <locale>

namespace {

[[gnu::constructor]] void choose() {
  std::setlocale(LC_ALL, "");
  std::locale::global(std::locale(""));
}

}  // namespace
