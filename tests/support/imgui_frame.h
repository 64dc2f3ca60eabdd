// Dear ImGui with a font but without a window, in the middle of a frame: for tests of drawing.
#pragma once

#include <gtest/gtest.h>
#include <imgui.h>

namespace springdrive::testing {

class ImGuiFrame : public ::testing::Test {
protected:
    ImGuiFrame() : context_(ImGui::CreateContext()) {
        ImGuiIO &io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = {1280.0F, 720.0F};
        unsigned char *pixels = nullptr;
        int width = 0;
        int height = 0;
        io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
        ImGui::NewFrame();
    }
    ~ImGuiFrame() override {
        ImGui::EndFrame();
        ImGui::DestroyContext(context_);
    }

private:
    ImGuiContext *context_;
};

} // namespace springdrive::testing
