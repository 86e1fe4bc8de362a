//! GLSL that changes.

use super::*;

/// GLSL that has changed is drawn with; what is broken is told with its place, and what was drawn before goes on.
#[test]
fn changed_glsl_is_compiled_while_the_window_goes_on() {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
            let to = to.join(entry.file_name());
            match entry.file_type().unwrap().is_dir() {
                true => copy(&entry.path(), &to),
                false => std::fs::copy(entry.path(), &to).map(drop).unwrap(),
            }
        }
    }
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let glsl = folder.path().join("glsl");
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl"), &glsl);
    let curve = glsl.join("tonemap.glsl");
    let text = std::fs::read_to_string(&curve).unwrap();
    let begin = "vec3 tonemap_neutral(vec3 color) {\n";
    let line = text.lines().position(|line| line == begin.trim_end()).expect("the curve is there") + 2;
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let lamps = asset("lamps.glb");
    let args = [lamps.as_str(), "--size", "160x90", "--glsl", "glsl"];
    let script = "reload\nframes 3\nscreenshot window.png\nlive live.json";
    let mut live = Vec::new();
    for (statement, is_other, problem) in
        [("", false, None), ("color *= 0.5;\n", true, None), ("colour *= 0.5;\n", false, Some("colour"))]
    {
        std::fs::write(&curve, text.replace(begin, &format!("{begin}{statement}"))).unwrap();
        let told = view(folder.path(), &screen.display, script, &args);
        match problem {
            None => assert_eq!(told, "", "{statement}"),
            Some(name) => {
                let place = format!("tonemap.glsl:{line}: error: ");
                assert!(told.contains(&place) && told.contains(name), "{told}");
            }
        }
        ontile(folder.path(), "", &["render", &lamps, "--size", "160x90", "-o", "render.png"]);
        let difference = difference(&picture("window.png"), &picture("render.png"));
        assert_eq!(difference.is_some(), is_other, "{statement}");
        live.push(std::fs::read_to_string(folder.path().join("live.json")).unwrap());
    }
    assert_eq!(live[1], live[0], "what was drawn with before is gone");
}
