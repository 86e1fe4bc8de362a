//! The public interface as a list, so that no change of it goes unseen: what hosts compile against is `tests/api.txt`.
//!
//! `ONTILE_UPDATE=1 cargo test --test api` writes it anew; a line that went, or is another, breaks hosts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::{Fields, ImplItem, Item, TraitItem, UseTree, Visibility};

/// A module of the sources.
struct Module {
    items: Vec<Item>,
    /// With whether it is public.
    children: BTreeMap<String, (bool, Module)>,
}

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

/// Whether an item exists only in tests or for them, in the C interface, whose list is its header, or in what judges frames, which
/// engines leave out.
fn is_left_out(attributes: &[syn::Attribute]) -> bool {
    let left_out = ["cfg (test)", "doc (hidden)", "\"capi\"", "\"measure\"", "\"shader-compiler\""];
    attributes.iter().any(|a| {
        let text = a.to_token_stream().to_string();
        left_out.iter().any(|known| text.contains(known))
    })
}

impl Module {
    /// Of a file; `folder` is where its children are.
    fn read(file: &Path, folder: &Path) -> Self {
        let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let mut children = BTreeMap::new();
        for item in &parsed.items {
            let Item::Mod(module) = item else { continue };
            if is_left_out(&module.attrs) || module.content.is_some() {
                continue;
            }
            let name = module.ident.to_string();
            let (beside, within) = (folder.join(format!("{name}.rs")), folder.join(&name));
            let file = if beside.exists() { beside } else { within.join("mod.rs") };
            children.insert(name, (is_public(&module.vis), Self::read(&file, &within)));
        }
        Self { items: parsed.items, children }
    }

    fn all<'a>(&'a self, into: &mut Vec<&'a Item>) {
        into.extend(&self.items);
        self.children.values().for_each(|(_, child)| child.all(into));
    }

    fn at(&self, path: &[String]) -> Option<&Self> {
        path.iter().try_fold(self, |module, name| module.children.get(name).map(|(_, child)| child))
    }
}

/// Tokens as they are usually spaced, roughly.
fn text(tokens: impl ToTokens) -> String {
    let text = tokens.to_token_stream().to_string();
    let spaced = [
        (" :: ", "::"),
        (" < ", "<"),
        (" <", "<"),
        (" >", ">"),
        (" ,", ","),
        (" :", ":"),
        ("& ", "&"),
        (" (", "("),
        ("( ", "("),
        (" )", ")"),
        (" ;", ";"),
        ("< ", "<"),
        ("[ ", "["),
        (" ]", "]"),
        (" . ", "."),
    ];
    spaced
        .iter()
        .fold(text, |text, (from, to)| text.replace(from, to))
        .replace("->", " ->")
        .replace("  ", " ")
}

/// The names that a `use` brings, with where they come from; a `*` is a name.
fn imports(tree: &UseTree, path: &mut Vec<String>, all: &mut Vec<(Vec<String>, String, String)>) {
    match tree {
        UseTree::Path(p) => {
            path.push(p.ident.to_string());
            imports(&p.tree, path, all);
            path.pop();
        }
        UseTree::Name(n) => all.push((path.clone(), n.ident.to_string(), n.ident.to_string())),
        UseTree::Rename(r) => all.push((path.clone(), r.ident.to_string(), r.rename.to_string())),
        UseTree::Glob(_) => all.push((path.clone(), "*".into(), "*".into())),
        UseTree::Group(group) => group.items.iter().for_each(|tree| imports(tree, path, all)),
    }
}

/// What makes the list.
struct Lister<'a> {
    root: &'a Module,
    items: Vec<&'a Item>,
    lines: BTreeSet<String>,
}

impl Lister<'_> {
    fn module(&mut self, path: &[String]) {
        let module = self.root.at(path).expect("paths come from the tree");
        let prefix =
            std::iter::once("ontile").chain(path.iter().map(String::as_str)).collect::<Vec<_>>().join("::");
        for item in &module.items {
            if let Item::Use(import) = item
                && is_public(&import.vis)
                && !is_left_out(&import.attrs)
            {
                let mut all = Vec::new();
                imports(&import.tree, &mut Vec::new(), &mut all);
                for (from, name, shown) in all {
                    self.import(&prefix, path, &from, &name, &shown);
                }
            } else {
                self.item(&prefix, item, None);
            }
        }
        let public: Vec<_> = module.children.iter().filter(|(_, (public, _))| *public).collect();
        for (name, _) in public {
            self.module(&[path, std::slice::from_ref(name)].concat());
        }
    }

    /// A name that is defined elsewhere: in a private module, or in another crate.
    fn import(&mut self, prefix: &str, path: &[String], from: &[String], name: &str, shown: &str) {
        let mut place: Vec<String> = match from.first().map(String::as_str) {
            Some("crate") => from[1..].to_vec(),
            _ => [path, from].concat(),
        };
        place.retain(|part| part != "self");
        let found = self.root.at(&place).filter(|_| !from.is_empty());
        let named = |item: &&Item| name == "*" || ident(item).is_some_and(|i| i == name);
        let items: Vec<&Item> = found.map(|m| m.items.iter().filter(named).collect()).unwrap_or_default();
        if items.is_empty() {
            let in_macro = found.and_then(|m| m.items.iter().find_map(|item| named_enum(item, name)));
            let deeper = found
                .is_some()
                .then(|| self.items.iter().copied().find(|i| ident(i).is_some_and(|i| i == name)));
            match (in_macro, deeper.flatten()) {
                (Some(variants), _) => {
                    self.lines.insert(format!("{prefix}::{shown} enum {{{variants}}}"));
                }
                (None, Some(item)) => self.item(prefix, item, Some(shown)),
                (None, None) => {
                    self.lines.insert(format!("{prefix}::{shown} = {}::{name}", from.join("::")));
                }
            }
        }
        for item in items {
            self.item(prefix, item, (name != "*").then_some(shown));
        }
    }

    fn item(&mut self, prefix: &str, item: &Item, shown: Option<&str>) {
        let Some(name) = ident(item) else { return };
        let path = format!("{prefix}::{}", shown.unwrap_or(&name));
        let mut add = |line: String| {
            self.lines.insert(line);
        };
        match item {
            Item::Struct(s) if is_public(&s.vis) => {
                add(format!("{path} struct{}", text(&s.generics)));
                if let Fields::Named(fields) = &s.fields {
                    let public = fields.named.iter().filter(|f| is_public(&f.vis));
                    for field in public {
                        add(format!("{path}.{}: {}", text(&field.ident), text(&field.ty)));
                    }
                }
                self.methods(&path, &name);
            }
            Item::Enum(e) if is_public(&e.vis) => {
                add(format!("{path} enum{}", text(&e.generics)));
                for variant in &e.variants {
                    let mut variant = variant.clone();
                    strip(&mut variant.attrs);
                    variant.fields.iter_mut().for_each(|f| strip(&mut f.attrs));
                    add(format!("{path}::{}", text(&variant)));
                }
                self.methods(&path, &name);
            }
            Item::Fn(f) if is_public(&f.vis) => add(format!("{path} {}", text(&f.sig))),
            Item::Const(c) if is_public(&c.vis) => add(format!("{path} const: {}", text(&c.ty))),
            Item::Type(t) if is_public(&t.vis) => add(format!("{path} type = {}", text(&t.ty))),
            Item::Trait(t) if is_public(&t.vis) => {
                add(format!("{path} trait: {}", text(&t.supertraits)));
                for item in &t.items {
                    if let TraitItem::Fn(f) = item {
                        add(format!("{path}: {}", text(&f.sig)));
                    }
                }
            }
            _ => {}
        }
    }

    /// Public functions and constants of a type's own, and the traits that it has by hand.
    fn methods(&mut self, path: &str, name: &str) {
        for item in &self.items {
            let Item::Impl(block) = item else { continue };
            let of = text(&block.self_ty);
            if of.split('<').next() != Some(name) || is_left_out(&block.attrs) {
                continue;
            }
            if let Some((_, made, _)) = &block.trait_ {
                self.lines.insert(format!("{path} impl {}", text(made)));
                continue;
            }
            for item in &block.items {
                let line = match item {
                    ImplItem::Fn(f) if is_public(&f.vis) => format!("{path}: {}", text(&f.sig)),
                    ImplItem::Const(c) if is_public(&c.vis) => {
                        format!("{path}::{}: {}", c.ident, text(&c.ty))
                    }
                    _ => continue,
                };
                self.lines.insert(line);
            }
        }
    }
}

fn strip(attributes: &mut Vec<syn::Attribute>) {
    attributes.clear();
}

fn ident(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Struct(i) => &i.ident,
        Item::Enum(i) => &i.ident,
        Item::Fn(i) => &i.sig.ident,
        Item::Const(i) => &i.ident,
        Item::Type(i) => &i.ident,
        Item::Trait(i) => &i.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

/// The variants and spellings of an enum that `named_enum!` makes.
fn named_enum(item: &Item, name: &str) -> Option<String> {
    let Item::Macro(call) = item else { return None };
    let mut tokens = call.mac.tokens.clone().into_iter().peekable();
    while let Some(token) = tokens.next() {
        if matches!(&token, TokenTree::Ident(ident) if ident == name)
            && let Some(TokenTree::Group(body)) = tokens.next()
        {
            let mut shown = TokenStream::new();
            let mut body = body.stream().into_iter();
            while let Some(token) = body.next() {
                match token {
                    // An attribute: the sharp and what follows it.
                    TokenTree::Punct(sharp) if sharp.as_char() == '#' => drop(body.next()),
                    other => shown.extend([other]),
                }
            }
            return Some(text(shown));
        }
    }
    None
}

#[test]
fn the_public_interface_is_the_one_that_is_listed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tree = Module::read(&root.join("src/lib.rs"), &root.join("src"));
    let mut items = Vec::new();
    tree.all(&mut items);
    let mut lister = Lister { root: &tree, items, lines: BTreeSet::new() };
    lister.module(&[]);
    let fresh: String = lister.lines.iter().map(|line| format!("{line}\n")).collect();
    for known in [
        "ontile::gpu::Renderer: fn record(",
        "ontile::plan::Strategy enum {",
        "ontile::scene::Mesh.positions: Vec<Vec3>",
    ] {
        assert!(fresh.contains(known), "the list lacks '{known}': this test does not see the interface");
    }
    let path: PathBuf = root.join("tests/api.txt");
    if std::env::var_os("ONTILE_UPDATE").is_some() {
        std::fs::write(&path, &fresh).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    let only = |a: &str, b: &str| {
        let b: BTreeSet<_> = b.lines().collect();
        a.lines().filter(|line| !b.contains(line)).map(|line| format!("\n    {line}")).collect::<String>()
    };
    assert!(
        kept == fresh,
        "the public interface is another. Gone:{}\nNew:{}\nIf that is meant: ONTILE_UPDATE=1 cargo test --test api",
        only(&kept, &fresh),
        only(&fresh, &kept)
    );
}
