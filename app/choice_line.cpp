#include "app/choice_line.h"

#include "app/commands/progress_line.h"

#include <string>

namespace springdrive {

ModelChoice choice_with_line(const ModelQuestion &question, const ModelMemory &memory, bool fresh) {
    ProgressLine line;
    const ModelProgress show = [&line](const std::string &what, double share) {
        line.show("springdrive: measuring models: " + what + ',', share);
    };
    return fresh ? measured_choice(question, memory, show) : known_choice(question, memory, show);
}

} // namespace springdrive
