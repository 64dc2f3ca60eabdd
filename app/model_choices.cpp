#include "app/model_choices.h"

#include "base/input_error.h"
#include "engine/model_choice/choice_cache.h"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <iostream>
#include <thread>
#include <utility>

namespace springdrive {

namespace {

std::string text_of(const std::string &what, double share) {
    return what + ", " + std::to_string(std::lround(100.0 * share)) + " %";
}

/// Writes over its own line again and again, and leaves none behind.
class TerminalLine {
public:
    ~TerminalLine() {
        if (is_terminal_) {
            std::cerr << "\r\033[K" << std::flush;
        }
    }
    void show(const std::string &text) const {
        if (is_terminal_) {
            std::cerr << "\r\033[Kspringdrive: measuring models: " << text << std::flush;
        }
    }

private:
    bool is_terminal_ = isatty(STDERR_FILENO) == 1;
};

} // namespace

Scene without_looks(const Scene &scene) {
    Scene bare;
    bare.file = scene.file;
    bare.surface = scene.surface;
    bare.flat_surface = scene.flat_surface;
    bare.shapes = scene.shapes;
    bare.lower_m = scene.lower_m;
    bare.upper_m = scene.upper_m;
    bare.metres_per_unit = scene.metres_per_unit;
    bare.in_metres = scene.in_metres;
    bare.planar = scene.planar;
    bare.tolerance = scene.tolerance;
    return bare;
}

std::optional<ModelChoice> remembered_choice(const ModelQuestion &question,
                                             const std::string &device_text) {
    return read_model_choice(model_cache_folder(),
                             model_choice_key(question, device_text, SPRINGDRIVE_VERSION));
}

ModelChoice measured_choice(const ModelQuestion &question, const std::string &device_text,
                            const ModelProgress &progress) {
    ModelChoice choice = choose_scene_model(question, progress);
    write_model_choice(model_cache_folder(),
                       model_choice_key(question, device_text, SPRINGDRIVE_VERSION), choice);
    return choice;
}

ModelChoice choice_with_progress(const ModelQuestion &question, const std::string &device_text,
                                 bool fresh) {
    if (!fresh) {
        if (std::optional<ModelChoice> choice = remembered_choice(question, device_text)) {
            return *std::move(choice);
        }
    }
    const TerminalLine line;
    return measured_choice(question, device_text, [&line](const std::string &what, double share) {
        line.show(text_of(what, share));
    });
}

void ModelMeasurement::begin(const ModelQuestion &question, const std::string &device_text) {
    forget();
    error_.clear();
    progress_ = std::make_shared<Progress>();
    std::packaged_task<ModelChoice()> measure(
        [question, device_text, scene = without_looks(*question.scene), progress = progress_] {
            ModelQuestion own = question;
            own.scene = &scene;
            return measured_choice(own, device_text, [&](const std::string &what, double share) {
                if (!progress->is_wanted) {
                    throw InputError("measuring was given up"); // which nobody will hear
                }
                const std::lock_guard lock(progress->mutex);
                progress->text = text_of(what, share);
            });
        });
    measuring_ = measure.get_future();
    // Detached, so that whoever closes the window need not wait for it.
    std::thread(std::move(measure)).detach();
}

void ModelMeasurement::forget() {
    if (progress_) {
        progress_->is_wanted = false;
    }
    measuring_ = {};
}

std::string ModelMeasurement::progress() const {
    if (!progress_) {
        return {};
    }
    const std::lock_guard lock(progress_->mutex);
    return progress_->text;
}

std::optional<ModelChoice> ModelMeasurement::take() {
    if (!measuring_.valid() ||
        measuring_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
        return std::nullopt;
    }
    try {
        return measuring_.get();
    } catch (const std::exception &error) {
        error_ = error.what();
        return std::nullopt;
    }
}

} // namespace springdrive
