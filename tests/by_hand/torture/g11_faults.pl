#!/usr/bin/perl
# Each system call of store and bytes fails, once and from then on, under a session of jobs: nobody hangs, nothing that was
# acknowledged is lost, and what is not in order ends the daemon with another status than 0 or by a signal of nobody.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use POSIX ();
use Time::HiRes qw(sleep time);
use Faults;
use Vt;

my %option = options();
my $cloud = sphere_ply(200);
my $query = 'points=40&iterations=1&polish=0';
# Not write: threads wake each other by it, and no such call fails for a disk. Writes that find none are f07_full's.
my @errors = map { my $call = $_; map { "$call:error=$_" } qw(EIO ENOSPC) }
    qw(fdatasync fsync pwrite64 renameat openat unlinkat ftruncate);

my ($hung, $lost, $crashed, $refused, $sessions, $first) = (0, 0, 0, 0, 0, '');

# Submits until refused or done; the jobs that were acknowledged. A daemon that does not answer counts as hung.
sub session {
    my ($daemon) = @_;
    my @ids;
    $daemon->{http} = HTTP::Tiny->new(timeout => 15);
    for (1 .. 3) {
        my $answer = eval { $daemon->post("/v1/resample?$query", $cloud, Prefer => 'respond-async') };
        if (!$answer) {
            $hung++ if $@ =~ /[Tt]imed out/;
            last;
        }
        $refused++ if $answer->{status} =~ /^50[37]$/;
        push @ids, json($answer)->{jobID} if $answer->{status} == 201;
    }
    return @ids;
}

# The faults that a daemon of its own does not make good.
sub faulty {
    my ($fault) = @_;
    my $daemon = Vt->start('disk-reserve' => '1M');
    my $tracer = inject($daemon, $fault) // do { print STDERR "g11: no strace here\n"; exit 1 };
    my @ids = session($daemon);
    sleep 0.05;
    kill 'TERM', $tracer; # lets go of it
    waitpid $tracer, 0;
    kill 'CONT', $daemon->{pid};
    my $pid = delete $daemon->{pid};
    kill 'TERM', $pid;
    my $exit = Vt::reap($pid);
    $hung++ if $exit eq 'still running';
    kill 'KILL', $pid if $exit eq 'still running';
    $crashed++ if $exit =~ /^signal/;
    my $again = Vt->start(dir => $daemon->{dir});
    for my $id (@ids) {
        my $info = eval { $again->finish($id) } // {};
        next if ($info->{status} // '') eq 'successful' || ($info->{message} // '') =~ /^(?:the daemon ended|reading|writing|making|naming)/i
            || ($info->{exception}{detail} // '') =~ /Input.output error|No space/;
        $lost++;
        $first ||= "$fault: $id is " . ($info->{status} // 'unknown') . ', ' . ($info->{message} // '');
    }
    $again->stop;
    $sessions++;
}

my @faults = map { ("$_:when=2", "$_:when=2+") } @errors;
my $until = time + ($option{long} ? 3600 : 8);
my $skip = $option{seed} % @faults;
push @faults, splice @faults, 0, $skip;
@faults = map { my $fault = $_; map { $fault =~ s/when=2/when=$_/r } 1 .. 12 } @faults if $option{long};
while (@faults && time < $until) { faulty(shift @faults) }
print STDERR "g11: $first\n" if $first ne '';
figure('G11', "jobs acknowledged and lost, in $sessions sessions with a failing call (refused: $refused)", $lost, 0);
figure('G11', 'sessions in which somebody hung', $hung, 0);
figure('G11', 'daemons ended by a signal', $crashed, 0);
