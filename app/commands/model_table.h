// A model choice for people: what was measured of each candidate, what is chosen, and why.
#pragma once

#include "engine/model_choice/model_choice.h"

#include <ostream>

namespace springdrive {

void write_model_table(std::ostream &out, const ModelChoice &choice);

} // namespace springdrive
