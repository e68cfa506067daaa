// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/label_bars.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/core/label_words.hpp"

namespace estancia::report {

Markup labelBars(const Vocabulary& vocabulary, DescriptorView mean, DescriptorView sigma, std::size_t count) {
  const auto best = bestLabels(mean, count);
  const float largest = best.empty() ? 1 : std::max(mean[best.front()], 1e-6F);
  Markup list;
  list.open("ol", {{"class", sigma.empty() ? "labels" : "labels spread"}});
  for (const std::size_t label : best) {
    const float p = mean[label];
    list.open("li").element("span", {{"class", "label"}, {"title", shorten(vocabulary[label], 200)}},
                            shorten(firstSynonym(vocabulary[label]), 40));
    list.open("span", {{"class", "bar"}})
        .element("i", {{"style", fmt::format("width:{}%", number(p > 0 ? 100 * p / largest : 0, 1))}}, "")
        .close();
    std::string text = significant(p);
    if (!sigma.empty()) text += " ± " + significant(sigma[label]);
    list.element("span", {{"class", "p"}}, text).close();
  }
  return list.close();
}

}  // namespace estancia::report
