// Localization in the map that a session makes.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/localizer.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/session/session_impl.hpp"

namespace estancia {
namespace {

const LocalizerOptions& checked(const LocalizerOptions& options) {
  validate(options);
  return options;
}

}  // namespace

Localizer::Localizer(MappingSession& session, const LocalizerOptions& options)
    : Localizer(std::make_shared<const LocalizerMap>(
                    readLocalizerMap(session.impl_->written(), session.impl_->mapper.impl().bankAtRest(),
                                     checked(options).maxImages)),
                options) {}

}  // namespace estancia
