#include "engine/study/methods/task.h"

#include "engine/study/methods/wrong_value.h"

namespace springdrive::study {

std::string what_is_wrong_with(const Task &task) {
    constexpr int kMostAlternatives = 8;
    return first_of(
        {unless_from_to("alternatives", task.alternatives, 2.0,
                        is_forced_choice(task.kind) ? kMostAlternatives : 2.0),
         unless_from_to("largest_false_alarm_rate", task.largest_false_alarm_rate, 0.0, 0.5)});
}

GuessRange guess_range(const Task &task) {
    if (is_forced_choice(task.kind)) {
        return {1.0 / task.alternatives, 1.0 / task.alternatives};
    }
    return {0.0, task.kind == TaskKind::yes_no ? task.largest_false_alarm_rate : 0.0};
}

} // namespace springdrive::study
