//! Where methods fail: extremes of every quantity, crossed. Whatever is asked, answers are finite, within physical limits,
//! and continuous at the edges.

mod films;
mod scenes;
mod surfaces;

/// Counts what was asserted, and says so at the end.
#[derive(Default)]
struct Count {
    combinations: usize,
    assertions: usize,
    failures: Vec<String>,
}

impl Count {
    /// One extreme situation begins.
    fn combination(&mut self) {
        self.combinations += 1;
    }

    fn assert(&mut self, holds: bool, what: impl FnOnce() -> String) {
        self.assertions += 1;
        if !holds {
            self.failures.push(what());
        }
    }

    fn finish(self, least: usize) {
        println!("{} combinations, {} assertions", self.combinations, self.assertions);
        assert!(self.combinations >= least, "only {} combinations", self.combinations);
        let shown: Vec<&str> = self.failures.iter().take(40).map(String::as_str).collect();
        let total = (self.failures.len(), self.assertions);
        assert!(self.failures.is_empty(), "{} of {} assertions fail:\n{}", total.0, total.1, shown.join("\n"));
    }
}
