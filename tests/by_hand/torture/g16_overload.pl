#!/usr/bin/perl
# More than the queue takes, by four keys at once: refusals come at once and say when to come back, what was accepted ends
# well, and each key has its turns. Then one key floods and another sends a job now and then.
use strict;
use warnings;
use Digest::SHA qw(sha256_hex);
use File::Temp qw(tempdir);
use FindBin;
use Getopt::Long;
use lib "$FindBin::Bin/../../support";
use List::Util qw(max);
use POSIX ();
use Time::HiRes qw(sleep time);
use Time::Local qw(timegm);
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or exit 2;
srand $seed;
my $queue = $long ? 256 : 40;
my $times = $long ? 10 : 3;
my $seconds = $long ? 5 : 2;
my @names = qw(alice bob carol dave);
my $keyed_count = 0;
my $dir = tempdir(CLEANUP => 1);

sub row { print join("\t", @_), "\n" }
sub verdict { return $_[0] ? 'ok' : 'short' }
sub secret { return "secret-of-$_[0]-0123456789abcdef" }

sub keyed {
    my ($quotas, %settings) = @_;
    my $file = "$dir/keys." . ++$keyed_count;
    open my $out, '>', $file or die "$file: $!";
    print $out "$_:submit,read:" . sha256_hex(secret($_)) . ":$quotas\n" for @names;
    print $out 'root:admin:' . sha256_hex(secret('root')) . "\n";
    close $out;
    chmod 0600, $file;
    return Vt->start('api-keys' => $file, %settings);
}

# Sends a job in the name of a key: status, Retry-After, seconds, identifier, time of the answer.
sub send_job {
    my ($daemon, $http, $name, $query, $cloud) = @_;
    my $began = time;
    my $answer = $http->request('POST', "$daemon->{url}/v1/resample?$query", {
        content => $cloud, headers => { Authorization => 'Bearer ' . secret($name), Prefer => 'respond-async' } });
    my $took = time - $began;
    my ($id) = $answer->{status} == 201 ? $answer->{content} =~ /"jobID":"([^"]+)"/ : ('-');
    return ($answer->{status}, $answer->{headers}{'retry-after'} // '-', $took, $id, $began + $took);
}

# Runs clients beside each other; the lines that they print.
sub clients {
    my (@clients) = @_;
    my @pipes = map {
        my $client = $_;
        my $pid = open(my $from, '-|') // die "fork: $!";
        if (!$pid) { $| = 1; eval { $client->() }; POSIX::_exit($@ ? 1 : 0) }
        $from;
    } @clients;
    return map { my $pipe = $_; map { chomp; [split / /] } <$pipe> } @pipes;
}

# Every job of a daemon, by identifier, once none waits or runs.
sub all_jobs {
    my ($daemon) = @_;
    my %job;
    my @with = (headers => { Authorization => 'Bearer ' . secret('root') });
    wait_until(sub { !@{ json($daemon->get('/v1/jobs?limit=1&status=accepted,running', @with))->{jobs} } }, 300)
        or die 'jobs do not end';
    $job{ $_->{jobID} } = $_ for @{ json($daemon->get('/v1/jobs?limit=10000', @with))->{jobs} };
    return %job;
}

sub percentile { my @sorted = sort { $a <=> $b } @_; return $sorted[int(0.99 * $#sorted)] // 0 }

# --- overload -------------------------------------------------------------------------------------

sub overload {
    my $daemon = keyed('jobs=100000,rate=100000', queue => $queue, jobs => 1);
    my $cloud = sphere_ply(300);
    my $each = POSIX::ceil($queue * $times / @names);
    my @answers = clients(map { my $name = $_; sub {
        my $http = HTTP::Tiny->new(timeout => 60);
        my $begin = time;
        for my $i (0 .. $each - 1) {
            my $wait = $begin + $i * $seconds / $each - time;
            sleep $wait if $wait > 0;
            print join(' ', $name, send_job($daemon, $http, $name, 'points=200&iterations=5', $cloud)), "\n";
        }
    } } @names);
    my @refused = grep { $_->[1] =~ /^(?:429|503)$/ } @answers;
    my @strange = grep { $_->[1] !~ /^(?:201|429|503)$/ } @answers;
    my @no_seconds = grep { $_->[2] !~ /^\d+$/ } @refused;
    my %of = map { $_->[4] => $_->[0] } grep { $_->[1] == 201 } @answers;
    my %job = all_jobs($daemon);
    my $lost = grep { !$job{$_} || $job{$_}{status} ne 'successful' } keys %of;
    my @order = sort { $job{$a}{started} cmp $job{$b}{started} || $a cmp $b } grep { $job{$_} } keys %of;
    my (%last, $late, $most);
    ($late, $most) = (0, 0);
    my %waits = map { $_ => 0 } @names;
    for my $at (0 .. $#order) {
        my $name = $of{ $order[$at] };
        my $before = $last{$name};
        $last{$name} = $at;
        next unless defined $before;
        $late++ if $job{ $order[$at] }{created} lt $job{ $order[$before] }{created};
        # Others' turns while this one waited, of which each other key has one by right.
        my $waited = grep { $job{ $order[$_] }{started} gt $job{ $order[$at] }{created} } $before + 1 .. $at - 1;
        $most = max($most, $waited);
    }
    my $sent = @answers;
    my $load = (split ' ', Vt::slurp('/proc/loadavg'))[0];
    row('G16', "of $sent submits by 4 keys in $seconds s, queue $queue: neither 201 nor 429 nor 503", scalar @strange, 0,
        verdict(!@strange));
    row('G16', 'refusals', scalar @refused, 'some', verdict(@refused > 0));
    row('G16', 'refusals without whole seconds in Retry-After', scalar @no_seconds, 0, verdict(!@no_seconds));
    my $p99 = 1000 * percentile(map { $_->[3] } @refused);
    row('G16', "refusals answered, p99, load $load", sprintf('%.1f ms', $p99), '10 ms', verdict($p99 <= 10));
    my @within = map { $_->{dur_s} } grep { ($_->{msg} // '') eq 'request' && $_->{status} =~ /^(?:429|503)$/ } $daemon->log_lines;
    row('G16', 'the same within the daemon, by its log', sprintf('%.1f ms', 1000 * percentile(@within)), '10 ms',
        verdict(percentile(@within) <= 0.010));
    row('G16', 'accepted jobs that did not end well, of ' . keys %of, $lost, 0, verdict($lost == 0));
    row('G16', 'jobs of a key that began before an earlier one of it', $late, 0, verdict($late == 0));
    row('G16', 'turns of others between two of a waiting key, of its fair share', sprintf('%.2f', $most / (@names - 1)), '2.00',
        verdict($most <= 2 * (@names - 1)));
    $daemon->stop;
}

# --- two keys -------------------------------------------------------------------------------------

sub two_keys {
    my $daemon = keyed('rate=100000', jobs => 1);
    my $cloud = sphere_ply(1200);
    my $query = 'points=600&iterations=8';
    my $until = time + ($long ? 60 : 4);
    my @answers = clients(
        sub { # sixteen at a time, again and again
            my $http = HTTP::Tiny->new(timeout => 60);
            while (time < $until) {
                my @answer = send_job($daemon, $http, 'alice', $query, $cloud);
                print "alice @answer\n";
                sleep 0.05 if $answer[0] != 201;
            }
        },
        sub {
            my $http = HTTP::Tiny->new(timeout => 60);
            sleep 1;
            while (time < $until - 1) {
                my @answer = send_job($daemon, $http, 'bob', $query, $cloud);
                print "bob @answer\n";
                sleep 0.5 + rand 0.5;
            }
        });
    my %of = map { $_->[4] => $_->[0] } grep { $_->[1] == 201 } @answers;
    my %told = map { $_->[4] => $_->[5] } grep { $_->[1] == 201 } @answers; # that it is accepted
    my @with = (headers => { Authorization => 'Bearer ' . secret('root') });
    $daemon->request('DELETE', "/v1/jobs/$_->{jobID}", @with)
        for @{ json($daemon->get('/v1/jobs?limit=1000&status=accepted', @with))->{jobs} };
    my %job = all_jobs($daemon);
    delete @job{ grep { !$job{$_}{started} } keys %job };
    my @flood = map { $job{$_} } grep { $job{$_} && $of{$_} eq 'alice' } keys %of;
    my ($begun, $ratio, $count) = (0, 0, 0);
    my $run = max map { seconds_of($_->{finished}) - seconds_of($_->{started}) } @flood;
    for my $mine (map { $job{$_} } grep { $job{$_} && $of{$_} eq 'bob' } keys %of) {
        my $before = grep { seconds_of($_->{started}) > $told{ $mine->{jobID} } && $_->{started} lt $mine->{started} } @flood;
        my $own = grep { $of{ $_->{jobID} } && $of{ $_->{jobID} } eq 'bob' && $_->{created} lt $mine->{created}
            && $_->{finished} gt $mine->{created} } values %job;
        next if $own; # it waited for one of its own as well
        $count++;
        $begun = max($begun, $before);
        $ratio = max($ratio, (seconds_of($mine->{started}) - seconds_of($mine->{created})) / $run);
    }
    row('two-keys', sprintf('jobs of a flood (%d) that began while one of another key (%d) waited, most', scalar @flood, $count),
        $begun, 0, verdict($count > 0 && $begun == 0));
    row('two-keys', sprintf('longest wait beside the flood, in running jobs (the longest: %.2f s)', $run), sprintf('%.2f', $ratio),
        '1.00', verdict($ratio <= 1.05));
    $daemon->stop;
}

sub seconds_of {
    my ($text) = @_;
    my ($y, $mo, $d, $h, $mi, $s) = $text =~ /^(\d+)-(\d+)-(\d+)T(\d+):(\d+):([\d.]+)Z$/ or die "no time: $text";
    return timegm(int $s, $mi, $h, $d, $mo - 1, $y) + $s - int $s;
}

overload();
two_keys();
