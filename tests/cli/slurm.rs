//! The scripts of contrib/slurm on a real Slurm: a cluster of this machine alone, on 127.0.0.1.

use std::net::TcpListener;

use super::*;

const SPP: u32 = 400;

/// A cluster that stops at the end.
struct Cluster(Folder);

impl Cluster {
    /// `None`, with a printed reason, where there can be none.
    fn start() -> Option<Self> {
        let has = |program: &str| {
            let found = Command::new("sh").args(["-c", &format!("command -v {program}")]).output();
            found.is_ok_and(|output| output.status.success())
        };
        let user = Command::new("id").arg("-u").output().unwrap().stdout;
        if user != b"0\n" || !["slurmctld", "slurmd", "sbatch", "munged"].iter().all(|program| has(program)) {
            println!("skipped: needs root, and Slurm (apt-get install --no-install-recommends slurm-wlm munge)");
            return None;
        }
        let cluster = Self(Folder::new("slurm"));
        let port = loop {
            let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
            if port < u16::MAX && TcpListener::bind(("127.0.0.1", port + 1)).is_ok() {
                break port.to_string();
            }
        };
        let up = cluster.command(&repository("tests/slurm/up.sh")).arg(cluster.0.file("cluster")).arg(port).output();
        let up = up.unwrap();
        assert!(up.status.success(), "{}", String::from_utf8_lossy(&up.stderr));
        Some(cluster)
    }

    /// In a folder of its own, where `pellicle` is on the path.
    fn command(&self, program: &str) -> Command {
        let binaries = Path::new(env!("CARGO_BIN_EXE_pellicle")).parent().unwrap();
        let path = format!("{}:{}", binaries.display(), std::env::var("PATH").unwrap_or_default());
        let mut command = Command::new(program);
        command.env("PATH", path).env("SLURM_CONF", self.0.file("cluster/slurm.conf")).current_dir(&self.0.0);
        command
    }

    fn text(&self, program: &str, arguments: &[&str]) -> String {
        let output = self.command(program).args(arguments).output().unwrap();
        assert!(output.status.success(), "{program} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    /// Submits shards of the still; the job's number.
    fn submit(&self, array: &str) -> String {
        let script = repository("contrib/slurm/still.sbatch");
        let (scene, spp) = (repository("tests/data/cli/room.dae"), SPP.to_string());
        let array = format!("--array={array}");
        let job = ["--parsable", "--cpus-per-task=1", &array, &script, &scene, "still.exr", &spp, "4"];
        self.text("sbatch", &[&job[..], &["--size", "200x150"]].concat())
    }

    /// Submits the merging of the parts for when a job has gone well.
    fn submit_merge(&self, after: &str) -> String {
        let dependency = format!("--dependency=afterok:{after}");
        let merge = "pellicle merge still.exr.*.part -o still.exr --hash > hash.txt";
        self.text("sbatch", &["--parsable", &dependency, "--kill-on-invalid-dep=yes", "--wrap", merge])
    }

    /// Waits until every task of a job has one of these states.
    fn wait_for(&self, job: &str, states: &[&str]) {
        let start = Instant::now();
        loop {
            let seen = self.text("squeue", &["--noheader", "--states=all", "--format=%T", "--jobs", job]);
            if !seen.is_empty() && seen.lines().all(|state| states.contains(&state)) {
                return;
            }
            assert!(
                start.elapsed() < Duration::from_secs(60),
                "{job} is {seen} instead of {states:?}; {}",
                self.logs()
            );
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn logs(&self) -> String {
        let logs = self.0.names().into_iter().filter(|name| name.ends_with(".log") || name.ends_with(".out"));
        logs.map(|name| format!("{name}:\n{}", fs::read_to_string(self.0.file(&name)).unwrap())).collect()
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let _ = self.command("scancel").args(["--full", "--state=RUNNING"]).output();
        let _ = self.command(&repository("tests/slurm/down.sh")).arg(self.0.file("cluster")).output();
    }
}

fn repository(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).to_str().unwrap().to_owned()
}

#[test]
fn a_still_in_shards_survives_a_killed_task_with_the_bits_of_the_whole() {
    let Some(cluster) = Cluster::start() else { return };
    let spp = SPP.to_string();
    let whole =
        ["render", "room.dae", "-o", &cluster.0.file("whole.exr"), "--spp", &spp, "--size", "200x150", "--hash"];
    let expected = succeed(&whole).stdout;

    let shards = cluster.submit("0-3");
    let merge = cluster.submit_merge(&shards);
    let victim = format!("{shards}_2");
    cluster.wait_for(&victim, &["RUNNING"]);
    let log = cluster.0.file(&format!("still.{victim}.log"));
    let start = Instant::now();
    while !fs::read_to_string(&log).is_ok_and(|text| text.contains(" spp, ")) {
        assert!(start.elapsed() < Duration::from_secs(30), "{}", cluster.logs());
        std::thread::sleep(Duration::from_millis(20));
    }
    cluster.text("scancel", &["--full", "--signal=KILL", &victim]);
    cluster.wait_for(&shards, &["COMPLETED", "FAILED", "CANCELLED", "NODE_FAIL"]);
    cluster.wait_for(&merge, &["CANCELLED"]);
    let parts = |cluster: &Cluster| -> Vec<String> {
        cluster.0.names().into_iter().filter(|name| name.ends_with(".part")).collect()
    };
    assert_eq!(parts(&cluster), ["still.exr.0000.part", "still.exr.0001.part", "still.exr.0003.part"]);
    let files: Vec<String> = parts(&cluster).iter().map(|name| cluster.0.file(name)).collect();
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    let gap = fail(2, &[&["merge", "-o", &cluster.0.file("gap.exr")], &files[..]].concat());
    assert!(gap.contains("--samples 200:300"), "{gap}");

    let again = cluster.submit("2");
    let merge = cluster.submit_merge(&again);
    cluster.wait_for(&merge, &["COMPLETED"]);
    assert_eq!(fs::read_to_string(cluster.0.file("hash.txt")).unwrap(), expected);
    assert!(is_complete(Path::new(&cluster.0.file("still.exr"))));
}
