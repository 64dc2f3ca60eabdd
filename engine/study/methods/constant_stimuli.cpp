#include "engine/study/methods/constant_stimuli.h"

#include "engine/study/methods/wrong_value.h"

namespace springdrive::study {

std::string what_is_wrong_with(const ConstantStimuli &method) {
    return first_of({unless_rising("levels", method.levels, 1),
                     unless_from_to("repetitions", method.repetitions, 1, 1000),
                     unless_from_to("blocks", method.blocks, 1, 1000)});
}

} // namespace springdrive::study
