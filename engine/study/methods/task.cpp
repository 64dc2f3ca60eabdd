#include "engine/study/methods/task.h"

#include "engine/study/methods/wrong_value.h"

namespace springdrive::study {

std::string validate(const Task &task) {
    return first_of({out_of_range(kTaskFields, task),
                     is_forced_choice(task.kind)
                         ? std::string()
                         : unless_from_to("alternatives", task.alternatives, 2.0, 2.0)});
}

GuessRange guess_range(const Task &task) {
    if (is_forced_choice(task.kind)) {
        return {1.0 / task.alternatives, 1.0 / task.alternatives};
    }
    return {0.0, task.kind == TaskKind::yes_no ? task.largest_false_alarm_rate : 0.0};
}

} // namespace springdrive::study
