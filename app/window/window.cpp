#include "app/window/window.h"

#include "app/host/software_renderer.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"

#include <epoxy/gl.h>
// epoxy must come before GLFW, which would bring in another OpenGL header.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ostream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace springdrive::app {

namespace {

/// The last error of GLFW.
std::string &glfw_error() {
    static std::string error;
    return error;
}

void on_glfw_error(int code, const char *text) {
    glfw_error() = std::string(text) + " (GLFW " + std::to_string(code) + ")";
}

} // namespace

GlWindow::GlWindow(const std::string &title, Size size, bool stays) {
    glfwSetErrorCallback(on_glfw_error);
    if (glfwInit() == GLFW_FALSE) {
        throw InputError(
            "no display: " + glfw_error() +
            "; start it from a desktop, or with xvfb-run on a virtual display, as ./app/run does");
    }
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_SAMPLES, 0); // the scene has its own, see MultisampledTarget
    glfwWindowHint(GLFW_AUTO_ICONIFY, stays ? GLFW_FALSE : GLFW_TRUE);
    window_ = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
        const std::string why = glfw_error();
        if (count_ == 0) {
            glfwTerminate();
        }
        throw InputError("no window with OpenGL 3.3: " + why +
                         "; install the graphics driver, or libgl1-mesa-dri for software OpenGL");
    }
    ++count_;
}

GlWindow::~GlWindow() {
    glfwDestroyWindow(window_);
    if (--count_ == 0) {
        glfwTerminate();
    }
}

bool GlWindow::draws_in_software() {
    const auto *renderer = reinterpret_cast<const char *>(glGetString(GL_RENDERER));
    return renderer != nullptr && is_software_renderer(renderer);
}

bool GlWindow::has_focus() const {
    return glfwGetWindowAttrib(window_, GLFW_FOCUSED) != GLFW_FALSE;
}

bool GlWindow::is_full_screen() const { return glfwGetWindowMonitor(window_) != nullptr; }

GlWindow::Size GlWindow::framebuffer() const {
    Size pixels;
    glfwGetFramebufferSize(window_, &pixels.width, &pixels.height);
    return pixels;
}

GlWindow::Size GlWindow::size() const {
    Size units;
    glfwGetWindowSize(window_, &units.width, &units.height);
    return units;
}

float GlWindow::pixel_scale() const {
    return static_cast<float>(framebuffer().width) / static_cast<float>(std::max(1, size().width));
}

namespace {

constexpr float kFontPixels = 15.0F;

constexpr Window::Size kDefaultSize{1280, 720};

constexpr float kKioskScale = 1.6F; ///< of a picture of the default size

bool chooses_size(const Window::Wish &wish) {
    return wish.size.width <= 0 || wish.size.height <= 0;
}

float display_scale(GLFWwindow *window) {
    float x = 1.0F;
    float y = 1.0F;
    glfwGetWindowContentScale(window, &x, &y);
    // On some systems the framebuffer is scaled instead of the window; ImGui then scales by itself.
    int window_width = 0;
    int framebuffer_width = 0;
    glfwGetWindowSize(window, &window_width, nullptr);
    glfwGetFramebufferSize(window, &framebuffer_width, nullptr);
    const float already =
        window_width > 0 ? static_cast<float>(framebuffer_width) / static_cast<float>(window_width)
                         : 1.0F;
    return std::clamp(std::max(x, y) / already, 1.0F, 4.0F);
}

/// Also while a text is typed.
constexpr std::array<std::pair<int, const char *>, 8> kNamedKeys{{{GLFW_KEY_ESCAPE, "Escape"},
                                                                  {GLFW_KEY_F1, "F1"},
                                                                  {GLFW_KEY_PAGE_UP, "PageUp"},
                                                                  {GLFW_KEY_PAGE_DOWN, "PageDown"},
                                                                  {GLFW_KEY_F6, "F6"},
                                                                  {GLFW_KEY_F9, "F9"},
                                                                  {GLFW_KEY_F10, "F10"},
                                                                  {GLFW_KEY_F11, "F11"}}};

/// By the keyboard's layout.
bool names(int key, int scancode, std::string_view letter) {
    const char *const name = glfwGetKeyName(key, scancode);
    return name != nullptr && name == letter;
}

} // namespace

Window::Window(const std::string &title, const Wish &wish)
    : GlWindow(title, chooses_size(wish) ? kDefaultSize : wish.size, wish.is_kiosk),
      frame_s_(wish.frame_s), is_unseen_(wish.is_unseen), is_kiosk_(wish.is_kiosk),
      text_size_(static_cast<float>(wish.text_size)) {
    glfwSetWindowUserPointer(glfw(), this);
    glfwSetWindowSizeLimits(glfw(), 640, 400, GLFW_DONT_CARE, GLFW_DONT_CARE);
    glfwMakeContextCurrent(glfw());
    glfwSwapInterval(wish.swaps_at_once ? 0 : 1);
    glfwShowWindow(glfw());
    start_scale_ = wish.scale > 0.0 ? static_cast<float>(wish.scale) : display_scale(glfw());
    scale_ = start_scale_ * text_size_;

    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr; // fixed layout; do not write imgui.ini
    choose_font();
    usable_scale_ = scale_;
    apply_look(scale_);
    if (chooses_size(wish) && wish.remembered.width > 0) {
        resize_within_screen(wish.remembered.width, wish.remembered.height);
    } else if (chooses_size(wish) && start_scale_ > 1.0F) { // a high-density screen
        return_to_default_size();
    }
    ImGui_ImplGlfw_InitForOpenGL(glfw(), false);
    listen();
    ImGui_ImplOpenGL3_Init("#version 330 core");
    if (is_kiosk_) {
        keep_as_kiosk();
    } else {
        use_keyboard();
    }
}

Window::~Window() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

void Window::listen() {
    glfwSetKeyCallback(glfw(), on_key);
    glfwSetCharCallback(glfw(), on_letter);
    glfwSetMouseButtonCallback(glfw(), on_mouse_button);
    glfwSetDropCallback(glfw(), on_drop);
    glfwSetScrollCallback(glfw(), ImGui_ImplGlfw_ScrollCallback);
    glfwSetWindowFocusCallback(glfw(), ImGui_ImplGlfw_WindowFocusCallback);
    glfwSetCursorEnterCallback(glfw(), ImGui_ImplGlfw_CursorEnterCallback);
}

/// All widgets can be reached by keys. The space bar stops the device: Enter presses buttons, too.
void Window::use_keyboard() {
    ImGuiIO &io = ImGui::GetIO();
    io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
    io.KeyMap[ImGuiKey_Space] = io.KeyMap[ImGuiKey_Enter];
}

void Window::resize_within_screen(int width, int height) {
    int left = 0;
    int top = 0;
    int max_width = width;
    int max_height = height;
    if (GLFWmonitor *monitor = glfwGetPrimaryMonitor(); monitor != nullptr) {
        glfwGetMonitorWorkarea(monitor, &left, &top, &max_width, &max_height);
    }
    glfwSetWindowSize(glfw(), std::min(width, max_width), std::min(height, max_height));
}

void Window::return_to_default_size() {
    if (!is_full_screen()) {
        resize_within_screen(static_cast<int>(kDefaultSize.width * start_scale_),
                             static_cast<int>(kDefaultSize.height * start_scale_));
    }
}

/// Draws the letters anew in another size. Not within a frame.
void Window::renew_text() {
    if (scale_ == start_scale_ * text_size_) {
        return;
    }
    scale_ = start_scale_ * text_size_;
    ImGui::GetIO().Fonts->Clear();
    choose_font();
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
    usable_scale_ = 0.0F;
}

/// On the screen that is there now: one may be switched off, or replaced.
void Window::keep_as_kiosk() {
    constexpr double kPause_s = 1.0;
    if (!is_full_screen() && glfwGetTime() >= next_fill_s_) {
        next_fill_s_ = glfwGetTime() + kPause_s;
        toggle_full_screen();
    }
    const Size now = size();
    if (now.width > 0 && now.height > 0) { // not of a window without a screen
        start_scale_ =
            kKioskScale *
            std::min(static_cast<float>(now.width) / static_cast<float>(kDefaultSize.width),
                     static_cast<float>(now.height) / static_cast<float>(kDefaultSize.height));
    }
}

/// Reduces the text size if panels would be clipped otherwise.
void Window::fit_scale_to_window() {
    const Size now = size();
    const float fits = std::min(static_cast<float>(now.width) / static_cast<float>(room_.width),
                                static_cast<float>(now.height) / static_cast<float>(room_.height));
    const float usable = std::clamp(fits, 0.5F * std::min(scale_, start_scale_), scale_);
    if (usable != usable_scale_) {
        usable_scale_ = usable;
        ImGui::GetIO().FontGlobalScale = usable / scale_;
        apply_look(usable);
    }
}

void Window::choose_font() {
    // Latin, Greek, and the superscripts, arrows and symbols that the panels use.
    static constexpr std::array<ImWchar, 15> kLetters{0x0020, 0x00FF, 0x0370, 0x03FF, 0x2010,
                                                      0x2027, 0x2070, 0x209F, 0x2190, 0x22FF,
                                                      0x21BA, 0x21BB, 0x2713, 0x2717, 0};
    ImGuiIO &io = ImGui::GetIO();
    std::error_code ignored;
    if (std::filesystem::exists(SPRINGDRIVE_FONT, ignored)) {
        io.Fonts->AddFontFromFileTTF(SPRINGDRIVE_FONT, std::round(kFontPixels * scale_), nullptr,
                                     kLetters.data());
        static constexpr std::array<ImWchar, 7> kWords{0x0020, 0x00FF, 0x0370, 0x03FF,
                                                       0x2010, 0x2027, 0};
        const auto add = [&](float lines) {
            return io.Fonts->AddFontFromFileTTF(
                SPRINGDRIVE_FONT, std::round(lines / kKioskScale * scale_), nullptr, kWords.data());
        };
        large_text_ = {add(40.0F), add(78.0F)};
        return;
    }
    font_warning_ = "no font with Greek letters at " SPRINGDRIVE_FONT
                    "; install fonts-dejavu-core to show the symbols";
    ImFontConfig plain;
    plain.SizePixels = std::round(kFontPixels * scale_);
    ImFont *const only = io.Fonts->AddFontDefault(&plain);
    large_text_ = {only, only};
}

bool Window::is_closing() const {
    return !is_kiosk_ && glfwWindowShouldClose(glfw()) != GLFW_FALSE;
}

void Window::begin_frame() {
    glfwPollEvents();
    if (is_kiosk_) {
        keep_as_kiosk();
    }
    renew_text();
    fit_scale_to_window();
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    if (frame_s_ > 0.0) {
        ImGui::GetIO().DeltaTime = static_cast<float>(frame_s_);
    }
    for (const KeyDown &key : input_.feed(ImGui::GetIO())) {
        note_key(key);
    }
    ImGui::NewFrame();
}

void Window::clear() {
    const Size pixels = framebuffer();
    glViewport(0, 0, pixels.width, pixels.height);
    glClearColor(0.09F, 0.10F, 0.12F, 1.0F);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void Window::end_frame() {
    ImGui::Render();
    if (!is_drawn()) {
        return;
    }
    const Size pixels = framebuffer();
    glViewport(0, 0, pixels.width, pixels.height);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    if (keep_last_frame_) {
        last_frame_size_ = pixels;
        last_frame_.resize(static_cast<std::size_t>(pixels.width) *
                           static_cast<std::size_t>(pixels.height) * 3);
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glReadPixels(0, 0, pixels.width, pixels.height, GL_RGB, GL_UNSIGNED_BYTE,
                     last_frame_.data());
    }
    glfwSwapBuffers(glfw());
}

bool Window::take_emergency_stop() { return std::exchange(emergency_stop_, false); }

std::vector<std::filesystem::path> Window::take_dropped_files() {
    return std::exchange(dropped_, {});
}

std::vector<KeyPress> Window::take_keys() { return std::exchange(keys_, {}); }

void Window::on_key(GLFWwindow *window, int key, int scancode, int action, int mods) {
    auto *self = static_cast<Window *>(glfwGetWindowUserPointer(window));
    if (key < 0 || key > GLFW_KEY_LAST) {
        return;
    }
    if (action == GLFW_RELEASE) {
        self->input_.release(key);
        return;
    }
    self->input_.press({key, scancode, mods, action == GLFW_REPEAT});
    const bool is_space =
        key == GLFW_KEY_SPACE && (!ImGui::GetIO().WantTextInput || ui::types_number());
    self->emergency_stop_ =
        self->emergency_stop_ || (action == GLFW_PRESS && (key == GLFW_KEY_F12 || is_space));
}

void Window::on_letter(GLFWwindow *window, unsigned letter) {
    static_cast<Window *>(glfwGetWindowUserPointer(window))->input_.letter(letter);
}

void Window::on_mouse_button(GLFWwindow *window, int button, int action, int /*mods*/) {
    if (button >= 0 && button < ImGuiMouseButton_COUNT) {
        double x = 0.0;
        double y = 0.0;
        glfwGetCursorPos(window, &x, &y);
        static_cast<Window *>(glfwGetWindowUserPointer(window))
            ->input_.button(button, action == GLFW_PRESS,
                            {static_cast<float>(x), static_cast<float>(y)});
    }
}

void Window::note_key(const KeyDown &pressed) {
    const auto &[key, scancode, mods, is_repeated] = pressed;
    const auto note = [&, mods = mods, is_repeated = is_repeated](const char *name) {
        keys_.push_back({name, (mods & GLFW_MOD_CONTROL) != 0, (mods & GLFW_MOD_SHIFT) != 0,
                         (mods & GLFW_MOD_ALT) != 0, is_repeated});
    };
    const auto named = std::ranges::find(kNamedKeys, key, &decltype(kNamedKeys)::value_type::first);
    if (named != kNamedKeys.end()) {
        note(named->second);
        return;
    }
    const bool is_order = (mods & GLFW_MOD_CONTROL) != 0 && names(key, scancode, "s");
    if (ImGui::GetIO().WantTextInput && !is_order) {
        return;
    }
    // By the keyboard's layout: GLFW's own codes are those of a US keyboard.
    if (const char *name = glfwGetKeyName(key, scancode); name != nullptr) {
        note(name);
    } else if (key == GLFW_KEY_HOME) {
        note("Home");
    }
}

void Window::toggle_full_screen() {
    auto &[x, y, width, height] = before_full_screen_;
    if (is_full_screen()) {
        glfwSetWindowMonitor(glfw(), nullptr, x, y, width, height, GLFW_DONT_CARE);
        return;
    }
    GLFWmonitor *monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode *mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
    if (mode != nullptr) {
        glfwGetWindowPos(glfw(), &x, &y);
        glfwGetWindowSize(glfw(), &width, &height);
        glfwSetWindowMonitor(glfw(), monitor, 0, 0, mode->width, mode->height, GLFW_DONT_CARE);
    }
}

void Window::on_drop(GLFWwindow *window, int count, const char **paths) {
    auto *self = static_cast<Window *>(glfwGetWindowUserPointer(window));
    self->dropped_.assign(paths, paths + count);
}

void Window::write_screenshot(std::ostream &out, const Rectangle &part) const {
    if (last_frame_.empty()) {
        throw InputError("--screenshot: no frame has been drawn yet");
    }
    const float pixel_scale =
        static_cast<float>(last_frame_size_.width) / static_cast<float>(std::max(1, size().width));
    const auto pixel = [&](float place, int most) {
        return std::clamp(static_cast<int>(std::lround(place * pixel_scale)), 0, most);
    };
    const bool is_whole = part.size.x <= 0.0F || part.size.y <= 0.0F;
    const int left = is_whole ? 0 : pixel(part.corner.x, last_frame_size_.width - 1);
    const int top = is_whole ? 0 : pixel(part.corner.y, last_frame_size_.height - 1);
    const int right =
        is_whole ? last_frame_size_.width : pixel(part.end().x, last_frame_size_.width);
    const int bottom =
        is_whole ? last_frame_size_.height : pixel(part.end().y, last_frame_size_.height);
    const std::ptrdiff_t row = std::ptrdiff_t{3} * last_frame_size_.width;
    const std::ptrdiff_t part_row = std::ptrdiff_t{3} * (right - left);
    std::vector<unsigned char> top_down;
    for (int y = top; y < bottom; ++y) {
        const auto from = last_frame_.begin() + (last_frame_size_.height - 1 - y) * row +
                          std::ptrdiff_t{3} * left;
        top_down.insert(top_down.end(), from, from + part_row);
    }
    const auto append = [](void *to, void *bytes, int size) {
        static_cast<std::ostream *>(to)->write(static_cast<const char *>(bytes), size);
    };
    stbi_write_png_to_func(append, &out, right - left, bottom - top, 3, top_down.data(),
                           static_cast<int>(part_row));
}

namespace {

bool is_modifier(int key) { return key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER; }

/// Whether ImGui itself does something when this key goes down.
bool acts(const ImGuiIO &io, int key) {
    const auto *const begin = std::begin(io.KeyMap);
    return io.KeyCtrl || std::find(begin, begin + ImGuiKey_A, key) != begin + ImGuiKey_A;
}

void set_modifiers(ImGuiIO &io) {
    const auto is_down = [&io](int left, int right) {
        return io.KeysDown[left] || io.KeysDown[right];
    };
    io.KeyCtrl = is_down(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
    io.KeyShift = is_down(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT);
    io.KeyAlt = is_down(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT);
    io.KeySuper = is_down(GLFW_KEY_LEFT_SUPER, GLFW_KEY_RIGHT_SUPER);
}

/// What one frame was given so far.
struct Given {
    std::vector<int> keys;   ///< that changed
    bool has_acted = false;  ///< a key did, for ImGui
    bool has_typed = false;  ///< letters
    bool has_button = false; ///< that changed
};

bool must_wait_for_key(const Given &given, const ImGuiIO &io, const KeyDown &key, bool is_down) {
    // Of a key that only writes, ImGui takes the letters.
    const bool only_writes = given.has_typed && !acts(io, key.key) && !is_modifier(key.key);
    if (!only_writes && std::ranges::find(given.keys, key.key) != given.keys.end()) {
        return true;
    }
    if (is_modifier(key.key)) {
        return given.has_acted || given.has_typed || given.has_button;
    }
    return is_down &&
           (given.has_acted || given.has_button || (given.has_typed && acts(io, key.key)));
}

} // namespace

std::vector<KeyDown> InputQueue::feed(ImGuiIO &io) {
    std::vector<KeyDown> pressed;
    Given given;
    for (; !waiting_.empty(); waiting_.pop_front()) {
        const auto &[kind, what, is_down, place] = waiting_.front();
        if (kind == Kind::key) {
            if (must_wait_for_key(given, io, what, is_down)) {
                break;
            }
            given.has_acted = given.has_acted || (is_down && acts(io, what.key));
            if (!what.is_repeated) { // ImGui repeats keys by itself
                given.keys.push_back(what.key);
                io.KeysDown[what.key] = is_down;
                set_modifiers(io);
            }
            if (is_down) {
                pressed.push_back(what);
            }
        } else if (kind == Kind::letter) {
            if (given.has_acted || given.has_button) {
                break;
            }
            given.has_typed = true;
            io.AddInputCharacter(static_cast<unsigned>(what.key));
        } else {
            if (given.has_acted || given.has_typed || given.has_button) {
                break;
            }
            given.has_button = true;
            is_button_down_[static_cast<std::size_t>(what.key)] = is_down;
            io.MousePos = place;
        }
    }
    std::ranges::copy(is_button_down_, std::begin(io.MouseDown));
    return pressed;
}

} // namespace springdrive::app
