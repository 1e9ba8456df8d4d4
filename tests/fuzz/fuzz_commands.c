/* fuzz_commands.c: whole command lines over assets that share files, images, links and
 * configurations. Nothing that is read changes without --in-place; with it, the asset that was
 * named keeps all but its normals, every other one says what it said; at status 2 and 3 nothing is
 * written; no file appears that was not asked for; the same command once more changes nothing. */
#include "command_scene.h"

enum { MOST_COMMANDS = 3 };

static void run_again(command *c, scene_state *once) {
    if (fuzz_command_run(c) > 1) fuzz_fail("%s cannot be done once more", c->verb);
    scene_state *twice = fuzz_scene_look();
    fuzz_scene_judge_again(once, twice, c);
    fuzz_command_run(c);
    scene_state *thrice = fuzz_scene_look();
    if (fuzz_scene_size(thrice) > fuzz_scene_size(twice)) fuzz_fail("buffers go on growing");
    fuzz_scene_forget(thrice);
    fuzz_scene_forget(twice);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes rest = {bytes, size};
    const uint32_t commands = 1 + fuzz_below(&rest, MOST_COMMANDS), again = fuzz_below(&rest, 4);
    fuzz_meter_begin(1 << 16);
    fuzz_scene_make(&rest);
    scene_state *before = fuzz_scene_look();
    for (uint32_t i = 0; i < commands; ++i) {
        command c;
        fuzz_command_take(&rest, &c);
        const int status = fuzz_command_run(&c);
        scene_state *after = fuzz_scene_look();
        fuzz_scene_judge(before, after, &c, status, NULL);
        fuzz_scene_forget(before);
        before = after;
        const int changes =
            c.verb[1] == 'a' || (c.verb[1] == 'o' ? !c.keeps_weld : c.fixes); /* or tangents */
        if (again == 0 && i + 1 == commands && c.in_place && c.one_input && changes && status < 2)
            run_again(&c, before);
    }
    fuzz_scene_forget(before);
    fuzz_scene_leave();
    fuzz_meter_end();
    return 0;
}
