// A model choice for people: what was measured of each candidate, what is chosen, and why.
#pragma once

#include "engine/lab/model_selection/model_choice.h"

#include <ostream>

namespace springdrive::app {

void write_model_table(std::ostream &out, const model_selection::ModelChoice &choice);

} // namespace springdrive::app
