#include "app/selection_line.h"

#include "app/commands/progress_line.h"

#include <string>

namespace springdrive::app {

model_selection::ModelSelection selection_with_line(const model_selection::ModelQuestion &question,
                                                    const session::ModelMemory &memory,
                                                    bool fresh) {
    ProgressLine line;
    const model_selection::ModelProgress show = [&line](const std::string &what, double share) {
        line.show("springdrive: measuring models: " + what + ',', share);
    };
    return fresh ? session::measured_selection(question, memory, show)
                 : session::known_selection(question, memory, show);
}

} // namespace springdrive::app
