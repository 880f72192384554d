//! Files of the page of the lab. They are built into the program.

/// One file of the page of the lab, such as a script.
pub struct Asset {
    /// Path of the file in the address, after the token (secret text that every address contains).
    pub path: &'static str,
    /// Content type of the file, which the server sends to the browser.
    pub kind: &'static str,
    /// Contents of the file as text.
    pub text: &'static str,
}

const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

/// All files of the page of the lab; the first is the page itself.
pub const ASSETS: &[Asset] = &[
    Asset { path: "", kind: "text/html; charset=utf-8", text: include_str!("page/index.html") },
    Asset { path: "shared.css", kind: STYLE, text: include_str!("../output/page/style.css") },
    Asset { path: "lab.css", kind: STYLE, text: include_str!("page/lab.css") },
    Asset { path: "scene.js", kind: SCRIPT, text: include_str!("../output/page/scene.js") },
    Asset { path: "main.js", kind: SCRIPT, text: include_str!("page/main.js") },
    Asset { path: "frames.js", kind: SCRIPT, text: include_str!("page/frames.js") },
    Asset { path: "live.js", kind: SCRIPT, text: include_str!("page/live.js") },
    Asset { path: "link.js", kind: SCRIPT, text: include_str!("page/link.js") },
    Asset { path: "controls.js", kind: SCRIPT, text: include_str!("page/controls.js") },
    Asset { path: "graph.js", kind: SCRIPT, text: include_str!("page/graph.js") },
    Asset { path: "profiles.js", kind: SCRIPT, text: include_str!("page/profiles.js") },
    Asset { path: "stage.js", kind: SCRIPT, text: include_str!("page/stage.js") },
    Asset { path: "words.js", kind: SCRIPT, text: include_str!("page/words.js") },
];

/// Script that takes the place of `link.js`, the connection to the program, in a file with recorded runs.
pub const RECORDED: &str = include_str!("page/recorded.js");

/// Page of the live view of a run. It has the same path as the page of the lab, and its other files are among
/// [`ASSETS`].
pub const LIVE: Asset = Asset { path: "", kind: ASSETS[0].kind, text: include_str!("page/live.html") };

/// Content security policy (rules that a browser follows for the page), which the server sends: the page may load only
/// its own files, and connect only to its own server.
macro_rules! policy {
    ($frames:literal) => {
        concat!(
            "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; ",
            "base-uri 'none'; form-action 'none'; frame-ancestors ",
            $frames
        )
    };
}

/// Content security policy of the lab: no other page may contain (embed) the page of the lab.
pub const POLICY: &str = policy!("'none'");

/// Content security policy of a live view: pages of this machine, such as notebooks, may contain (embed) the page of
/// the view. The page has no controls that change anything.
pub const LIVE_POLICY: &str = policy!("http://127.0.0.1:* http://localhost:*");
