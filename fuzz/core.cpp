// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <opencv2/core/mat.hpp>

#include "estancia/core/base64.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/png.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/vocabulary.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(core, toml) {
  ConfigFile config("input.toml", bytes);
  std::string text;
  config.read({{"text", false, "a text", [&](const toml::node& node) { text = config.text(node); }},
               {"flag", false, "a flag", [&](const toml::node& node) { config.flag(node); }},
               {"number", false, "a number", [&](const toml::node& node) { config.number(node, -1, 1); }},
               {"count", false, "a count", [&](const toml::node& node) { config.integer(node, 0, 9); }},
               {"file", false, "a file", [&](const toml::node& node) { config.inside(node); }},
               {"list", false, "a list",
                [&](const toml::node& node) {
                  for (const toml::node& entry : config.list(node)) config.text(entry);
                }},
               {"one", true, "a choice", [&](const toml::node& node) {
                  config.choice<int>(node, {{"a", 1}, {"b", 2}});
                }}});
}

FUZZ_TARGET(core, vocabulary) {
  const Vocabulary vocabulary = readVocabulary(inputFile("labels.txt", bytes));
  for (const std::string& label : vocabulary.labels())
    if (printable(label) != label) throw std::logic_error("a label has control characters");
}

FUZZ_TARGET(core, base64) {
  fromBase64(bytes);
}

FUZZ_TARGET(core, png) {
  fromPng({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, {512, 512});
}

FUZZ_TARGET(core, printable) {
  const std::string once = printable(bytes);
  if (printable(once) != once) throw std::logic_error("what is printable changes");
}

}  // namespace estancia::fuzz
