// Model choices as JSON: for `springdrive inspect` and for the cache files.
#pragma once

#include "engine/session/model/model_selection.h"

#include <nlohmann/json.hpp>

namespace springdrive::model_selection {

/// With names and units in the keys. An error that is not finite becomes null.
[[nodiscard]] nlohmann::ordered_json json_of(const ModelSelection &choice);

/// @throw InputError for JSON that `json_of` would not have written.
[[nodiscard]] ModelSelection model_selection_of(const nlohmann::ordered_json &json);

} // namespace springdrive::model_selection
