// Loads scenes in the background, so that neither window nor servo waits for one.
#pragma once

#include "base/background.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/model_selection/model_choice.h"
#include "engine/scene/load_progress.h"
#include "engine/scene/scene.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace springdrive::session {

/// A scene ready for eye and hand.
struct LoadedScene {
    scene::Scene scene;
    contact::HapticSurface surface;
    std::string sha256; ///< of its file
    std::optional<model_selection::ModelChoice>
        choice{}; ///< of the model that it is to run with, if one was chosen
};

/// Loads a glTF file and prepares its surface. Any thread.
/// @throw InputError as `load_gltf` does.
/// @throw NotWanted soon after `progress` was given up
[[nodiscard]] std::unique_ptr<LoadedScene> load_scene(const std::filesystem::path &file,
                                                      const device::Workspace &workspace,
                                                      scene::LoadProgress &progress);

/// Of one thread. Going away waits until what is being loaded has ended, unfinished, which takes
/// a second at the most.
class SceneLoader {
public:
    /// What is still to be done with a loaded scene, in the background too: it owns all it uses,
    /// and a scene with which it fails is not shown.
    using Finish = std::function<void(LoadedScene &, scene::LoadProgress &, BackgroundTalk &)>;

    explicit SceneLoader(device::Workspace workspace) : workspace_(std::move(workspace)) {}
    ~SceneLoader() { progress_->give_up(); }
    SceneLoader(const SceneLoader &) = delete;
    SceneLoader &operator=(const SceneLoader &) = delete;

    /// That scenes requested from now on are fitted into.
    void set_workspace(const device::Workspace &workspace) { workspace_ = workspace; }

    /// Loads this one next; of several asked for meanwhile the last wins.
    void request(const std::filesystem::path &file, const Finish &finish);

    /// The scene, once, when it is ready. Where it failed, `error` tells why from then on.
    [[nodiscard]] std::unique_ptr<LoadedScene> take();

    [[nodiscard]] bool is_loading() const { return loading_.is_busy(); }
    [[nodiscard]] std::string progress() const { return progress_->text(); }
    [[nodiscard]] const std::string &error() const { return error_; }

private:
    struct Request {
        std::filesystem::path file;
        Finish finish;
    };

    device::Workspace workspace_;
    std::shared_ptr<scene::LoadProgress> progress_ = std::make_shared<scene::LoadProgress>();
    std::optional<Request> next_; ///< asked for while another was loading
    std::string error_;
    Background<std::unique_ptr<LoadedScene>> loading_; ///< the last, so that it is joined first
};

} // namespace springdrive::session
