/* Of host.c: what is asked and made before frames are drawn. */
/* What is known before there is a renderer, and pipelines ahead of it. */
static void ask_ahead(OntileDevice *ontile, OntileWorld *world, OntileOptions *options, OntilePipelineCache *cache,
                      int has_overlay) {
    ON(ontile_pipeline_cache_prepare(cache, ontile, world, options));
    OntileBudget budget;
    ON(ontile_plan_budget(ontile, world, options, FRAMES, WIDTH, HEIGHT, &budget));
    check(budget.renderer_bytes > 0 && budget.target_bytes > budget.lazy_target_bytes, "a budget");
    size_t bytes = 0;
    ON(ontile_plan_pipelines(ontile, world, options, &bytes, NULL));
    char *lines = calloc(1, bytes + 1);
    ON(ontile_plan_pipelines(ontile, world, options, &bytes, lines));
    check(strstr(lines, "tone") && !strstr(lines, "overlay") == !has_overlay, lines);
    free(lines);
    check(ontile_plan_text(ontile, NULL, options, &bytes, NULL) == ONTILE_RESULT_ERROR_ARGUMENT, "no world");
}

/* Whether the renderer's plan is the one that was told before. */
static void check_plan(OntileDevice *ontile, OntileWorld *world, OntileOptions *options, OntileRenderer *renderer) {
    size_t ahead = 0, own = 0;
    ON(ontile_plan_text(ontile, world, options, &ahead, NULL));
    ON(ontile_renderer_plan(renderer, &own, NULL));
    char *texts[2] = {malloc(ahead), malloc(own)};
    ON(ontile_plan_text(ontile, world, options, &ahead, texts[0]));
    ON(ontile_renderer_plan(renderer, &own, texts[1]));
    check(own > 0 && ahead == own && memcmp(texts[0], texts[1], own) == 0, "the plan is another");
    free(texts[0]);
    free(texts[1]);
}

/* A triangle at the picture's left upper corner, green through an image of two texels. */
static void draw_over(OntileRenderer *renderer, uint32_t slot) {
    OntileOverlayVertex corners[3] = {{{0, 0}, {0.25f, 0.5f}, {0, 128, 0, 128}},
                                      {{30, 0}, {0.25f, 0.5f}, {0, 128, 0, 128}},
                                      {{0, 20}, {0.25f, 0.5f}, {0, 128, 0, 128}}};
    uint32_t indices[3] = {0, 1, 2};
    OntileOverlayPart part = {.clip_px = {0, 0, WIDTH, HEIGHT}, .first_index = 0, .index_count = 3};
    ON(ontile_renderer_set_overlay(renderer, slot, corners, 3, indices, 3, &part, 1, 2));
    part.index_count = 4;
    check(ontile_renderer_set_overlay(renderer, slot, corners, 3, indices, 3, &part, 1, 2) ==
              ONTILE_RESULT_ERROR_UNSUPPORTED, "an index beyond the last");
    check(ontile_renderer_set_overlay(renderer, FRAMES, corners, 3, indices, 3, NULL, 0, 2) ==
              ONTILE_RESULT_ERROR_ARGUMENT, "a slot beyond the last");
}
