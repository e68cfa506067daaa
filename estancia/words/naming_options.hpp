// Naming options: which words zones and areas are called by.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/core/options.hpp"

namespace estancia {

struct NamingOptions {
  enum class Words {
    /// A familiar word instead of several rare ones, where WordNet is installed.
    wordNet,
    /// The labels as the network has them.
    raw
  };
  Words words = Words::wordNet;
};
OptionGroup declare(NamingOptions& options);

}  // namespace estancia
