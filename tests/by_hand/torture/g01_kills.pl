#!/usr/bin/perl
# kill -9 at random moments while clients upload, run, download and delete: what was accepted is there afterwards, with the
# bytes of a run that nothing interrupted, and nothing else is.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use File::Temp qw(tempdir);
use List::Util qw(max);
use POSIX ();
use Time::HiRes qw(sleep time);
use Faults;
use Vt;

my %option = options();
my $kills = $option{count} // ($option{long} ? 2000 : 25);
my $cloud = sphere_ply(600);
my @queries = map { "points=$_&iterations=4&polish=2&seed=$_" } 60, 90, 120, 200;
my $dir = tempdir(CLEANUP => 1);
my $port = free_port();
my @settings = (dir => $dir, listen => "127.0.0.1:$port", 'keep-inputs' => 0, queue => 10000);
srand $option{seed};

my @want;
my $calm = Vt->start;
push @want, sha256_hex($calm->post("/v1/resample?$_", $cloud)->{content}) for @queries;
$calm->stop;

# A client notes what was acknowledged, a line at a time: "A ID QUERY" accepted, "D ID" about to be deleted.
sub client {
    my ($number) = @_;
    my $pid = fork // die "fork: $!";
    return $pid if $pid;
    srand $option{seed} * 1000 + $number;
    open my $notes, '>>', "$dir/notes.$number" or POSIX::_exit(1);
    my $self = bless { url => "http://127.0.0.1:$port", http => HTTP::Tiny->new(timeout => 5) }, 'Vt';
    while (!-e "$dir/enough") {
        my $query = int rand @queries;
        my $answer = eval { $self->post("/v1/resample?$queries[$query]", $cloud, Prefer => 'respond-async') };
        if (!$answer || $answer->{status} != 201) { sleep 0.02; next }
        my $id = json($answer)->{jobID};
        syswrite $notes, "A $id $query\n";
        next if rand() < 0.5;
        sleep 0.2 * rand;
        my $got = eval { $self->get("/v1/jobs/$id/results/cloud") } // next;
        syswrite $notes, "W $id\n" if $got->{status} == 200 && sha256_hex($got->{content}) ne $want[$query];
        next if rand() < 0.5;
        syswrite $notes, "D $id\n";
        eval { $self->request('DELETE', "/v1/jobs/$id") };
    }
    POSIX::_exit(0);
}

# Seconds of computing of a process so far; the zygote, which starts beside it, is not counted.
sub computed {
    my ($pid) = @_;
    my ($user, $system) = Vt::slurp("/proc/$pid/stat") =~ /\) (?:\S+ ){11}(\d+) (\d+)/ or return 0;
    return ($user + $system) / POSIX::sysconf(POSIX::_SC_CLK_TCK());
}

# A start that is refused says why and ends. One that does not listen after 20 s, on a machine that gives it no time or a disk
# that stands still, is in the slowest start, and is told with what it waits for.
my ($slowest, $dearest, $refused, $daemon) = (0, 0, 0);
my @clients = map { client($_) } 1 .. 3;
my $until = time + ($option{long} ? $ENV{TORTURE_SECONDS} // 1e9 : 1e9);
for my $kill (1 .. $kills) {
    if (time > $until) { $kills = $kill - 1; last }
    my $began = time;
    $daemon = eval { Vt->start(@settings) };
    if (!$daemon) { $refused += $@ !~ /does not listen/; print STDERR Sockets::load(), ": $@" }
    $slowest = max($slowest, time - $began);
    $dearest = max($dearest, computed($daemon->{pid})) if $daemon;
    sleep 0.02 + 0.1 * rand;
    $daemon->stop('KILL') if $daemon;
}
open my $enough, '>', "$dir/enough";
waitpid $_, 0 for @clients;

my (%accepted, %deleted, $wrong);
$wrong = 0;
for my $line (map { split /\n/, Vt::slurp($_) } glob "$dir/notes.*") {
    my ($what, $id, $query) = split / /, $line;
    $accepted{$id} = $query if $what eq 'A';
    $deleted{$id} = 1 if $what eq 'D';
    $wrong++ if $what eq 'W';
}
$daemon = Vt->start(@settings);
my ($lost, $failed) = (0, 0);
for my $id (sort keys %accepted) {
    my $info;
    wait_until(sub { $info = json($daemon->get("/v1/jobs/$id")); ($info->{status} // '') !~ /^(accepted|running)$/ }, 60);
    next if $deleted{$id};
    if (($info->{status} // '') =~ /^\d+$/) { $lost++; next }
    if ($info->{status} ne 'successful') { $failed++; next }
    $wrong++ if sha256_hex($daemon->get("/v1/jobs/$id/results/cloud")->{content}) ne $want[$accepted{$id}];
}
sub strays {
    my @found;
    for my $file ($daemon->blobs) {
        my ($id) = $file =~ m{^([0-9a-f-]{36})\.[^/]+$};
        push @found, $file if !defined $id || $daemon->get("/v1/jobs/$id")->{status} == 404;
    }
    return @found;
}
my @strays;
wait_until(sub { !(@strays = strays()) }, 20); # the sweeper looks behind the jobs
print STDERR "$_\n" for @strays;
my $jobs = keys %accepted;
figure('G01', "jobs lost, of $jobs accepted, $kills times kill -9", $lost, 0);
figure('G01', 'results that differ from an uninterrupted run', $wrong, 0);
figure('G01', 'jobs failed', $failed, 0);
figure('G01', 'starts refused', $refused, 0);
figure('G01', 'files left that no job has', scalar(@strays), 0);
figure('G01', 'slowest start, the time that it computes', sprintf('%.2f s', $dearest), '0.5 s at most', $dearest <= 0.5);
figure('G01', 'slowest start', sprintf('%.2f s', $slowest), '1 s at most', $slowest <= 1);
$daemon->stop;
