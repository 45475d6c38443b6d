#!/usr/bin/perl
# usage: figures.pl [PART...]: what several daemons on one PostgreSQL and one S3 reach, with real servers that are started here; parts:
# churn, delay, finish, standby, workers, large, events, faults, eventsource, resume, capacity; and upgrade. Needs what `make scale` installs, and build/release/tests/by_hand/scale/churn for churn.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", "$FindBin::Bin/../../scale";
use POSIX ();
use Scale;
use Time::HiRes qw(time sleep);
use Vt;

my %want = map { $_ => 1 } @ARGV ? @ARGV : qw(churn delay finish standby workers large events faults eventsource resume capacity);
my $cloud = sphere_ply(4000);
$| = 1;
start_postgres() or die Vt::slurp("$Scale::dir/postgres.out");

# Jobs beside an idle transaction that sees what was there before them: versions of rows pile up.
if ($want{churn}) {
    my $count = $ENV{VT_CHURN} //= 10_000;
    local @ENV{qw(VT_STORE VT_POSTGRES CK_FORK CK_DEFAULT_TIMEOUT)} = ('postgres', "host=127.0.0.1 port=$Scale::postgres user=voronoid", 'no', 0);
    ask('postgres', 'CREATE DATABASE churn');
    local %ENV = (%ENV, $ENV{VT_TOLD} ? (VT_LISTEN => $ENV{VT_POSTGRES}) : ()); # and another daemon is told, and looks at once
    { local $ENV{VT_CHURN} = 1; `build/release/tests/by_hand/scale/churn` }
    my @watch = map { Vt->start(store => "postgresql://voronoid\@127.0.0.1:$Scale::postgres/churn", 'store-listen' => "postgresql://voronoid\@127.0.0.1:$Scale::postgres/churn",
        blobs => "postgresql://voronoid\@127.0.0.1:$Scale::postgres/churn", role => 'api') } $ENV{VT_TOLD} ? 1 : ();
    my @tables = qw(job job_text job_end job_run round ledger);
    my $sizes = 'SELECT ' . join ', ', map { "'$_ ' || coalesce((SELECT sum(pg_table_size(relid)) FROM pg_partition_tree('$_')), pg_table_size('$_')) || ' of ' || (SELECT coalesce(sum(pg_column_size($_.*)), 0) FROM $_)" } @tables;
    open my $idle, '|-', 'psql', '-Xq', "host=127.0.0.1 port=$Scale::postgres user=voronoid dbname=churn" or die "psql: $!";
    $idle->autoflush;
    print $idle "BEGIN ISOLATION LEVEL REPEATABLE READ; SELECT count(*) AS before FROM job;\n";
    sleep 1;
    my $began = time;
    print "churn: $count jobs\n", grep { /^#/ } `build/release/tests/by_hand/scale/churn`;
    printf "  %.0f s; bytes of each table, and of its live rows: %s\n", time - $began, ask('churn', $sizes);
    close $idle;
    ask('churn', 'VACUUM');
    print '  after that transaction and a vacuum: ', ask('churn', $sizes), "\n";
    print '  of job, free for what comes: ', ask('churn', 'CREATE EXTENSION IF NOT EXISTS pg_freespacemap; SELECT sum(avail) FROM pg_freespace(\'job_over\')'), "\n";
    `build/release/tests/by_hand/scale/churn`;
    print "  after $count more: ", ask('churn', $sizes), "\n";
}
exit unless grep { $_ ne 'churn' } keys %want;

start_swift() or die Vt::slurp("$Scale::dir/proxy.out");
ask('postgres', 'CREATE DATABASE daemons');
my %place = (store => "postgresql://voronoid\@127.0.0.1:$Scale::postgres/daemons", blobs => "s3:http://127.0.0.1:$Scale::swift{proxy}/bucket");
my @api = map { Vt->start(%place, role => 'api') } 1 .. 2;

# How old a job's records are when a stream of another daemon has them, each millisecond's; and how long a job waits for another daemon
# that is free: by polling, and with hints.
for my $way ($want{delay} ? (['by polling'], ['with --store-listen', 'store-listen' => $place{store}]) : ()) {
    my ($name, @more) = @$way;
    my $worker = Vt->start(%place, @more, role => 'all', jobs => 1, threads => 1);
    my $front = Vt->start(%place, @more, role => 'api');
    my $id = $front->submit('points=2000&iterations=8000&delta=0&polish=0', $cloud);
    my $own = fork // die "fork: $!"; # the daemon that runs it shows when its clock began
    my $records = sub {
        my ($daemon, $file, $stream) = (@_, $_[0]->events("/v1/jobs/$id/events"));
        open my $out, '>', "$Scale::dir/$file" or die $!;
        while (my $event = $stream->next_event) { printf $out "%.4f %.4f\n", time, $1 if $event->{event} eq 'progress' && $event->{data} =~ /"seconds":([\d.]+)/ }
    };
    if (!$own) { $records->($worker, 'own'); POSIX::_exit(0) }
    $records->($front, 'other');
    waitpid $own, 0;
    my ($began, $last, @ages) = 9e99;
    for (split /\n/, Vt::slurp("$Scale::dir/own")) { my ($at, $seconds) = split; $began = $at - $seconds if $at - $seconds < $began }
    for (split /\n/, Vt::slurp("$Scale::dir/other")) {
        my ($at, $seconds) = split;
        for (my $made = $last // $seconds; $made < $seconds; $made += .001) { push @ages, $at - $began - $made }
        $last = $seconds;
    }
    @ages = sort { $a <=> $b } @ages;
    my @waits;
    for (1 .. 40) {
        my $one = $front->submit('points=100&iterations=1&polish=0', $cloud);
        wait_until(sub { $front->status($one) eq 'successful' });
        push @waits, ask('daemons', "SELECT started - created FROM job WHERE id = '$one'") / 1000;
        sleep rand .5;
    }
    @waits = sort { $a <=> $b } @waits;
    printf "delay %s: records of another daemon's job are %.3f s old in the median, %.3f s in 99 of 100 cases, at most %.3f s (%.0f s of records);"
        . " a job waits %.3f s in the median, at most %.3f s\n", $name, @ages[@ages / 2, .99 * @ages, -1], @ages / 1000, @waits[@waits / 2, -1];
    $_->stop for $worker, $front;
}

# PostgreSQL stops for 20 s (and for 45 s, longer than the lease) while a job runs that ends meanwhile.
for my $away ($want{finish} ? (20, 45) : ()) {
    my @workers = map { Vt->start(%place, role => 'worker', jobs => 1) } 1 .. 2;
    my $id = $api[0]->submit('points=2000&iterations=150&delta=0', $cloud);
    wait_until(sub { $api[0]->status($id) eq 'running' });
    stop_postgres('immediate');
    sleep $away;
    start_postgres();
    my $status = wait_until(sub { my $s = eval { $api[0]->status($id) } // ''; $s eq 'successful' || $s eq 'failed' ? $s : undef });
    my $started = () = join('', map { $_->log_text } @workers) =~ /"msg":"job started","job":"$id"/g;
    printf "finish: PostgreSQL away for %d s: %s, started %d times, attempt %s\n", $away, $status, $started,
        ask('daemons', "SELECT attempt FROM job WHERE id = '$id'");
    $_->stop for @workers;
}

# A standby takes the place of the server while jobs come and run. It has each change before that is acknowledged.
if ($want{standby}) {
    my $second = free_port();
    copy_server($second);
    my $both = "postgresql://voronoid\@127.0.0.1:$Scale::postgres,127.0.0.1:$second/daemons?target_session_attrs=read-write";
    my @daemons = map { Vt->start(%place, store => $both, jobs => 1) } 1 .. 2;
    my (@ids, $refused);
    for my $number (1 .. 60) {
        my $answer = $daemons[$number % 2]->post('/v1/resample?points=1000&iterations=40&delta=0', $cloud, Prefer => 'respond-async');
        $answer->{status} == 201 ? push @ids, json($answer)->{jobID} : $refused++;
        stop_postgres('immediate') if $number == 20;
        promote() if $number == 40;
        sleep .2;
    }
    my %ends;
    for my $id (@ids) {
        my $status = wait_until(sub { my $s = eval { $daemons[0]->status($id) } // ''; $s =~ /^(?:successful|failed)$/ ? $s : undef });
        $ends{ $status // 'stuck' }++;
    }
    printf "standby: %d accepted, %d refused meanwhile; ended: %s\n", scalar @ids, $refused // 0, join ', ', map { "$ends{$_} $_" } sort keys %ends;
    $_->stop for @daemons;
    Scale::as_user(programs() . '/pg_ctl', '-w', '-D', "$Scale::dir/standby", '-m', 'immediate', 'stop');
    start_postgres();
}

# The same jobs by one worker and by two, of one thread each: from the first start to the last end, by the rows. What a job takes beside
# its engine, and what passes between two jobs of a worker, is time in which its core has nothing to do.
if ($want{workers}) {
    my @rates;
    for my $count (1, 2) {
        my @workers = map { Vt->start(%place, role => 'worker', jobs => 1, threads => 1) } 1 .. $count;
        my @groups = ([map { $_->{pid} } @workers], [map { $_->{pid} } @api], [(Vt::slurp("$Scale::dir/data/postmaster.pid") =~ /^(\d+)/)], [values %Scale::pid]);
        my @before = map { cpu(@$_) } @groups;
        my $last = ask('daemons', 'SELECT coalesce(max(seq), 0) FROM job');
        my @ids = map { $api[$_ % 2]->submit($ENV{VT_LOAD} // 'points=2000&iterations=300&delta=0', $cloud) } 1 .. ($ENV{VT_JOBS} // 12);
        sleep 1 until ask('daemons', "SELECT count(*) FROM job WHERE status IN ('accepted', 'running')") eq '0'; # each costs a process there
        my ($ms, $beside, $between) = split /\|/, ask('daemons', "SELECT max(finished) - min(started), avg(finished - started - 1000 * seconds),"
            . ' avg(started - before) FROM (SELECT started, finished, lag(finished) OVER (PARTITION BY owner ORDER BY started) AS before,'
            . " (SELECT sum(value::float) FROM json_each_text(report::json -> 'seconds') WHERE key <> 'read') AS seconds FROM job JOIN job_end USING (seq) WHERE job.seq > $last) AS jobs");
        printf "  CPU s of %d workers, of the api daemons, of PostgreSQL, of Swift and pgbouncer: %s; %.1f s; ms of a job beside its engine %.0f,"
            . " between two of a worker %.0f\n", $count, join(', ', map { sprintf '%.2f', cpu(@{ $groups[$_] }) - $before[$_] } 0 .. $#groups),
            $ms / 1000, $beside, $between;
        push @rates, 1000 * @ids / $ms;
        $_->stop for @workers;
    }
    printf "workers: %.2f jobs/s by one, %.2f by two: %.2f x\n", @rates, $rates[1] / $rates[0];
}

# The first byte of a large file from a daemon that has no copy, and from the same daemon again.
if ($want{large}) {
    my $padded = $cloud =~ s/(?=^end_header)/element padding 1\nproperty list int uchar bytes\n/mr . pack('l<', 64 << 20) . 'x' x (64 << 20);
    my $id = $api[0]->submit('points=100', $padded);
    my @seconds = map { `curl -sS -o /dev/null -w '%{time_starttransfer} of %{time_total}' $api[1]{url}/v1/jobs/$id/input` } 1 .. 2;
    print "large: first byte of 64 MiB after $seconds[0] s, again $seconds[1] s\n";
    $api[0]->request('DELETE', "/v1/jobs/$id");
}

# Jobs write 100,000 events, eight at a time; readers of other daemons are cut at random and go on from the last one.
if ($want{events}) {
    my $worker = Vt->start(%place, role => 'worker', jobs => 8, threads => 2);
    my @ids = map { $api[0]->submit("points=300&iterations=6300&delta=0&polish=0&seed=$_", $cloud) } 1 .. 16;
    my @children;
    for my $reader (1 .. 20) {
        my $pid = fork // die "fork: $!";
        push @children, $pid;
        next if $pid;
        srand $reader;
        my $bad = 0;
        for my $id (grep { $reader % 4 == $_ % 4 } 0 .. 15) {
            my ($last, $cuts, $wrong) = follow($ids[$id], 400, @api);
            print "events: reader $reader of job $id saw $last, cut $cuts times, $wrong missed or twice\n";
            $bad += $wrong + ($last < 6300);
        }
        POSIX::_exit($bad > 0);
    }
    my $failed = 0;
    for my $pid (@children) { waitpid $pid, 0; $failed += $? != 0 }
    print "events: $failed of 20 readers missed one or saw one twice; numbers of the last ones: ",
        ask('daemons', 'SELECT sum(last) FROM (SELECT max(last) AS last FROM event GROUP BY seq) AS jobs'), "\n";
}

# For VT_SECONDS a worker is killed each 2 s and PostgreSQL is started anew each 20 s, with S3 behind a proxy that drops one connection of
# ten at once and the others some time, and PostgreSQL behind pgbouncer. Each job is submitted until it is accepted.
if ($want{faults}) {
    ask('postgres', 'CREATE DATABASE faults');
    my $cutter = start_cutter(sub { rand() < .1 ? 0 : 20_000 + int rand 200_000 });
    my @of = (store => "postgresql://voronoid\@127.0.0.1:$Scale::pooler/faults", blobs => "s3:http://127.0.0.1:$cutter/bucket/faults");
    my $wanted = Vt->start(jobs => 1)->post('/v1/resample?points=500', $cloud)->{content};
    my @apis = map { wait_until(sub { eval { Vt->start(@of, role => 'api') } }) } 1 .. 2;
    my @workers = (undef) x 3;
    my ($count, $seconds, $began, $killed, $stopped, %refused, @ids) = ($ENV{VT_JOBS} // 200, $ENV{VT_SECONDS} // 60, time, 0, 0);
    while (@ids < $count || time - $began < $seconds) {
        my $passed = time - $began;
        if ($passed < $seconds && $passed > 2 * $killed) {
            my $one = $killed++ % 3;
            $workers[$one]->stop('KILL') if $workers[$one];
            $workers[$one] = eval { Vt->start(@of, role => 'worker', jobs => 2, threads => 1) };
        }
        for (grep { !$_ && $passed >= $seconds } @workers) { $_ = eval { Vt->start(@of, role => 'worker', jobs => 2, threads => 1) } }
        if ($passed < $seconds && $passed > 20 * ($stopped + 1)) {
            $stopped++;
            stop_postgres('immediate');
            start_postgres();
        }
        my $number = @ids;
        my $answer = $number < $count
            ? $apis[rand 2]->post('/v1/resample?points=500', $cloud, Prefer => 'respond-async', 'Idempotency-Key' => "number-$number") : { status => 0 };
        push @ids, json($answer)->{jobID} if $answer->{status} == 201;
        $refused{"$answer->{status} $1"}++
            if $answer->{status} != 201 && ($answer->{content} // '') =~ /"title":"(.*?)"/;
        sleep .1;
    }
    $_ //= wait_until(sub { eval { Vt->start(@of, role => 'worker', jobs => 2, threads => 1) } }) for @workers;
    my $left = wait_until(sub { (ask('faults', "SELECT count(*) FROM job WHERE status IN ('accepted', 'running')") || 0) eq '0' }) ? 0 : 'some';
    my $same = grep { my $id = $_; wait_until(sub { $apis[rand 2]->get("/v1/jobs/$id/results/cloud")->{content} eq $wanted }) } @ids;
    printf "faults: %d workers killed, PostgreSQL stopped %d times, submits refused: %s; of %d jobs %s, %s stuck; %d with the same bytes; %s ran again\n",
        $killed - 3, $stopped, join(', ', map { "$refused{$_} with $_" } sort keys %refused), $count, ask('faults', "SELECT string_agg(n || ' ' || status, ', ') FROM (SELECT count(*) AS n, status FROM job GROUP BY status) AS s"),
        $left, $same, ask('faults', 'SELECT count(*) FROM job WHERE attempt > 1');
    end_child('cutter');
}

# npm's eventsource follows a job by a balancer whose first daemon is killed meanwhile.
if ($want{eventsource}) {
    my $npm = "$Scale::dir/npm";
    system('npm', 'install', '--silent', '--no-audit', '--no-fund', '--prefix', $npm, 'eventsource@3') == 0 or die 'npm cannot install eventsource';
    my @replicas = map { Vt->start(%place, role => 'api') } 1 .. 2;
    my $worker = Vt->start(%place, role => 'worker', jobs => 1);
    my $balancer = start_cutter(sub { 1 << 40 }, undef, map { $_->{port} } @replicas);
    my $id = $replicas[1]->submit('points=2000&iterations=10000&delta=0', $cloud);
    Scale::write_file("$npm/follow.mjs", <<'JS');
import { EventSource } from 'eventsource'
const source = new EventSource(process.argv[2])
let last = 0, bad = 0, seen = 0, opened = 0
source.onopen = () => opened++
const take = event => {
    const number = Number(event.lastEventId.split('.')[1])
    if (number <= last) bad++
    last = number
    if (++seen === 20) console.log('now')
    if (event.type !== 'end') return
    console.log(`saw ${seen}, opened ${opened} times, ${bad} twice or out of order, the end is ${event.data}`)
    source.close()
}
for (const name of ['status', 'progress', 'replaced', 'end']) source.addEventListener(name, take)
JS
    open my $node, '-|', 'node', "$npm/follow.mjs", "http://127.0.0.1:$balancer/v1/jobs/$id/events" or die "node: $!";
    <$node>;
    $replicas[0]->stop('KILL');
    print 'eventsource: ', <$node>;
}

# What a core does: CPU seconds of the daemon that answers, of the worker, of PostgreSQL and of Swift for small jobs, for events that
# another daemon shows, and for bytes.
if ($want{capacity}) {
    my $worker = Vt->start(%place, role => 'worker', jobs => 2, threads => 1);
    my $of = sub {
        my ($what, $count, $unit, $run) = @_;
        my @groups = ([$api[0]{pid}, $api[1]{pid}], [$worker->{pid}], [Vt::slurp("$Scale::dir/data/postmaster.pid") =~ /^(\d+)/], [grep { $_ } @Scale::pid{qw(account container object proxy memcached)}]);
        my ($began, @before) = (time, map { cpu(@$_) } @groups);
        $run->();
        my @used = map { cpu(@{ $groups[$_] }) - $before[$_] } 0 .. $#groups;
        printf "capacity: %s: %.1f s; %s a CPU s: api %s, worker %s, PostgreSQL %s, Swift %s\n", $what, time - $began, $unit,
            map { $_ > .02 ? sprintf '%.0f', $count / $_ : 'uncounted' } @used;
    };
    my $small = sphere_ply(1000);
    my $jobs = $ENV{VT_JOBS} // 300;
    $of->("$jobs jobs of 1,000 points to 100", $jobs, 'jobs', sub {
        my @ids = map { $api[$_ % 2]->submit('points=100&iterations=1&polish=0', $small) } 1 .. $jobs;
        $api[0]->finish($_) for @ids;
        $api[1]->get("/v1/jobs/$_/results/cloud") for @ids;
    });
    $of->('6,300 events, written and followed by two', 6300, 'events', sub {
        my $id = $api[0]->submit('points=300&iterations=6300&delta=0&polish=0', $small);
        my @readers = map { my $pid = fork // die; if (!$pid) { follow($id, 1 << 30, $api[$_]); POSIX::_exit(0) } $pid } 0, 1;
        waitpid $_, 0 for @readers;
    });
    my $padded = $small =~ s/(?=^end_header)/element padding 1\nproperty list int uchar bytes\n/mr . pack('l<', 64 << 20) . 'x' x (64 << 20);
    my $id;
    $of->('64 MiB uploaded', 64, 'MiB', sub { $id = $api[0]->submit('points=100&iterations=1', $padded); $api[0]->finish($id) });
    $of->("64 MiB downloaded $_", 64, 'MiB', sub { `curl -sS -o /dev/null $api[1]{url}/v1/jobs/$id/input` }) for 'from a daemon without a copy', 'from one that has a copy';
    $worker->stop;
}

# Daemons of VT_OLDER, another build, give way to those of this one while jobs come: each goes to a daemon that was ready when it was
# asked last, once a second, as balancers do.
if ($want{upgrade}) {
    ask('postgres', 'CREATE DATABASE upgrade');
    my @of = (store => $place{store} =~ s/daemons$/upgrade/r, blobs => "$place{blobs}/upgrade", jobs => 1, threads => 1, 'drain-delay' => 4);
    my ($newer, $older) = ($Vt::binary, $ENV{VT_OLDER} // die 'VT_OLDER is the path of another build');
    my $start = sub { local $Vt::binary = $_[0]; return map { Vt->start(@of) } 1 .. 2 };
    my @old = $start->($older);
    my ($began, $asked, $stopped, @new, @ready, @ids, %refused) = (time, 0, 0);
    while ((my $passed = time - $began) < 50) {
        @new = $start->($newer) if $passed > 15 && !@new;
        kill 'TERM', $old[$stopped++]{pid} if $stopped < 2 && $passed > 25 + 8 * $stopped;
        if (time > $asked + 1) {
            @ready = grep { $_->{http}->get("$_->{url}/readyz")->{status} == 200 } @old, @new;
            $asked = time;
        }
        my $answer = eval { $ready[rand @ready]->post('/v1/resample?points=1000&iterations=60&delta=0', $cloud, Prefer => 'respond-async') } // { status => 599, content => $@ };
        if ($answer->{status} == 201) { push @ids, json($answer)->{jobID} }
        else { $refused{"$answer->{status} " . substr $answer->{content}, 0, 200}++ }
        sleep .5;
    }
    my %ends;
    $ends{ $new[0]->finish($_)->{status} }++ for @ids;
    my $ran = sub { my $text = join '', map { $_->log_text } @_; return scalar(() = $text =~ /"msg":"job started"/g) };
    printf "upgrade: %d accepted, refused: %s; ended: %s; started by the older %d, by the newer %d, again %s; the older ended with %s\n", scalar @ids,
        join(', ', map { "$refused{$_} x $_" } sort keys %refused) || 'none', join(', ', map { "$ends{$_} $_" } sort keys %ends), $ran->(@old), $ran->(@new),
        ask('upgrade', 'SELECT count(*) FROM job WHERE attempt > 1'), join ' and ', map { $_->stop } @old;
    print "  $_->{log}: ", grep { /"level":"(?:warn|error)"/ } $_->log_text =~ /.*\n/g for @old, @new;
    $_->stop for @new;
}

# Each process and method whose runs make checkpoints: a daemon that runs one is killed at a random moment after the checkpoint, another
# one goes on, and the bytes are those of a daemon that nobody kills. VT_POINTS of each input; VT_ROWS: a pattern of the rows that are run.
if ($want{resume}) {
    my ($points, $only, $threads) = ($ENV{VT_POINTS} // 400_000, $ENV{VT_ROWS} // '.', 1);
    my %in = clouds($points);
    my @rows = grep { "@$_" =~ /$only/ } map { [split] } grep { /\S/ } split /\n/, <<'ROWS';
        sphere resample ratio=1&delta=0
        sphere resample ratio=.5&anderson=4&iterations=40&delta=0
        sphere resample ratio=.5&method=kmeans&iterations=60&delta=0
        noisy  resample ratio=.5&method=wlop&delta=0
        noisy  resample ratio=1&method=ear&rho=0
        dome   resample ratio=.5&method=isotropic&delta=0
        dome   resample ratio=.3&density=curvature&delta=0
        box    resample ratio=.3&density=edges&groups=5&delta=0
        sphere resample ratio=.5&density=attribute:weight&delta=0
        sphere resample ratio=.3&metric=lp&delta=0
        dome   resample ratio=.3&metric=anisotropic&delta=0
        dome   resample ratio=.3&metric=anisotropic&cells=euclid&iterations=60&delta=0
        box    resample ratio=.5&edges=sites&delta=0
        dome   resample ratio=.5&boundary=sites&delta=0
        dome   resample ratio=.5&boundary=fill&delta=0
        sphere resample ratio=.7&evenness=cover&order=progressive&normals=fit
        sphere resample ratio=.7&coherence=.5&previous
        noisy  denoise  filters=mls,outliers&ratio=1
        dome   upsample ratio=2&polish=40
        dome   upsample ratio=3&method=insert
        sphere simplify ratio=.5&delta=0
        dome   mesh     ratio=.5&delta=0
        dome   mesh     ratio=.5&repair=auto
        noisy  mesh     ratio=.5&method=ear
ROWS
    my $alone = Vt->start(jobs => 2, threads => 2);
    ask('postgres', 'CREATE DATABASE resume');
    my @of = (store => $place{store} =~ s/daemons$/resume/r, blobs => "$place{blobs}/resume");
    my $front = Vt->start(@of, role => 'api');
    my ($first, @bytes);
    my $submit = sub {
        my ($daemon, $in, $process, $query) = @_;
        my $answer = $daemon->post("/v1/$process?$query", $in{$in}, Prefer => 'respond-async');
        return $answer->{status} == 201 ? json($answer)->{jobID} : die "$process?$query: $answer->{content}";
    };
    my $all = sub {
        my ($daemon) = @_;
        my $previous = (grep { "@$_" =~ /previous/ } @rows) ? $submit->($daemon, 'sphere', 'resample', 'ratio=.7&coherence=.5') : '';
        return $previous, map { $submit->($daemon, @$_[0, 1], $_->[2] =~ s/previous$/previous=job:$previous/r) } @rows;
    };
    my $result = sub { my $answer = $_[0]->get("/v1/jobs/$_[1]/results/cloud"); $answer->{status} == 200 ? $answer->{content} : die $answer->{content} };
    local $Vt::PATIENCE = 7200;
    my ($before, @unbroken) = $all->($alone);
    my @whole = map { my $end = $alone->finish($unbroken[$_]); print "resume: $end->{message}\n" if $end->{status} ne 'successful'; $result->($alone, $unbroken[$_]) } 0 .. $#rows;
    $alone->stop;
    my $base;
    my @workers = map { Vt->start(@of, role => 'worker', jobs => 3, threads => $threads) } 1 .. 2;
    ($base, my @ids) = $all->($front);
    my %row = map { $ids[$_] => $_ } 0 .. $#ids;
    my (%killed, %noticed, %went_on, @logs);
    srand($ENV{VT_SEED} // 1);
    while ((my @running = split /\n/, ask('resume', "SELECT id FROM job WHERE status IN ('accepted', 'running')")) > 0) {
        my %kept = map { m{([-0-9a-f]{36})\.input-checkpoint$} ? ($1 => 1) : () } objects();
        my %victims;
        for my $at (0 .. $#workers) {
            my $text = $workers[$at]->log_text;
            for my $id (@running) {
                next unless exists $row{$id} && $text =~ /"msg":"job started","job":"$id"/;
                $noticed{$id} //= time - $killed{$id} if $killed{$id};
                $went_on{$id} = $1 if $text =~ /"msg":"job resumed from a checkpoint","job":"$id"[^\n]*"iteration":(\d+)/;
                $victims{$at} = 1 if $kept{$id} && !$killed{$id};
            }
        }
        sleep .1;
        my ($at) = keys %victims or next;
        sleep rand 1.5;
        $workers[$at]->stop('KILL');
        my $text = $workers[$at]->log_text;
        push @logs, $text;
        for my $id (@running) { $killed{$id} //= time if $text =~ /"msg":"job started","job":"$id"/ && $kept{$id} && $front->status($id) eq 'running' }
        $workers[$at] = Vt->start(@of, role => 'worker', jobs => 3, threads => $threads);
    }
    my $texts = join '', @logs, map { $_->log_text } @workers;
    my ($same, $resumed) = (0, 0);
    for my $at (0 .. $#rows) {
        my $id = $ids[$at];
        my $times = () = $texts =~ /"msg":"job resumed from a checkpoint","job":"$id"/g;
        my $equal = $result->($front, $id) eq $whole[$at];
        ($same, $resumed) = ($same + $equal, $resumed + ($times > 0));
        printf "resume: %-8s %-9s %-62s %s, attempts %s, went on %d times%s\n", @{ $rows[$at] }, $equal ? 'same bytes' : 'OTHER BYTES',
            ask('resume', "SELECT attempt FROM job WHERE id = '$id'"), $times, defined $noticed{$id} ? sprintf(', noticed after %.1f s', $noticed{$id}) : '';
    }
    printf "resume: %d of %d with the same bytes, %d went on from a checkpoint; %d daemons killed\n", $same, scalar @rows, $resumed, scalar @logs;
    $_->stop for @workers, $front;
}

sub programs { return (sort { $b cmp $a } glob '/usr/lib/postgresql/*/bin')[0] }

# Starts a standby of the server, for which each commit waits from now on.
sub copy_server {
    my ($port) = @_;
    my $standby = "$Scale::dir/standby";
    Scale::as_user(programs() . '/pg_basebackup', '-R', '-U', 'voronoid', '-h', '127.0.0.1', '-p', $Scale::postgres, '-D', $standby) == 0
        && Scale::as_user(programs() . '/pg_ctl', '-w', '-D', $standby, '-l', "$standby.log", '-o', "-p $port -k $Scale::dir", 'start') == 0
        or die Vt::slurp("$Scale::dir/postgres.out");
    ask('postgres', $_) for "ALTER SYSTEM SET synchronous_standby_names = '*'", 'SELECT pg_reload_conf()';
}

sub promote { return Scale::as_user(programs() . '/pg_ctl', '-w', '-D', "$Scale::dir/standby", 'promote') }

# Seconds of CPU of these processes and all that they began.
sub cpu {
    my (%of, %children, $ticks);
    for my $file (glob '/proc/[0-9]*/stat') {
        my ($pid, undef, $parent, @all) = (eval { Vt::slurp($file) } // '') =~ /^(\d+) \(.*\) (\S) (\d+) (.*)/ or next;
        my @field = split ' ', $all[0];
        $of{$pid} = $field[9] + $field[10] + $field[11] + $field[12];
        push @{ $children{$parent} }, $pid;
    }
    my @left = @_;
    while (defined(my $pid = shift @left)) { $ticks += $of{$pid} // 0; push @left, @{ $children{$pid} // [] } }
    return ($ticks // 0) / 100;
}

# Clouds of so many points: a sphere with a weight, a noisy one, a dome with a border, a box.
sub clouds {
    my ($n) = @_;
    my $cloud = sub {
        return "ply\nformat binary_little_endian 1.0\nelement vertex " . @_ . "\n" . join('', map { "property float $_\n" } qw(x y z weight))
            . "end_header\n" . join '', map { pack 'f<4', @$_ } @_;
    };
    srand 1;
    my @sphere = map {
        my ($z, $angle) = (1 - 2 * ($_ + .5) / $n, $_ * 2.399963229728653 + .3 * sin($_ * 12.9898));
        my $r = sqrt(1 - $z * $z);
        [$r * cos $angle, $r * sin $angle, $z, 2 + $z];
    } 0 .. $n - 1;
    my @noisy = map { my $far = 1 + .01 * (rand() - .5); [map { $_ * $far } @$_] } @sphere;
    my @box = map { my @x = (2 * rand() - 1, 2 * rand() - 1); splice @x, $_ % 3, 0, $_ % 2 ? 1 : -1; [@x, 1] } 1 .. $n;
    return (sphere => $cloud->(@sphere), noisy => $cloud->(@noisy), dome => $cloud->(grep { $_->[2] > -.2 && $_->[0] < .8 } @sphere), box => $cloud->(@box));
}
