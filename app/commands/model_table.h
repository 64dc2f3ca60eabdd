// A model choice as text: the measurements of each candidate, the selection and its reason.
#pragma once

#include "engine/session/model/model_selection.h"

#include <ostream>

namespace springdrive::app {

void write_model_table(std::ostream &out, const model_selection::ModelSelection &choice);

} // namespace springdrive::app
